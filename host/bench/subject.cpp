// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/subject.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "codegen/codegen.hpp"
#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

Vector3d vector(const std::array<double, 3>& x) { return {x[0], x[1], x[2]}; }

/// What is measured is the body's force, not what keeps a hand safe: a finger jumps here.
Tables unlimited(Tables tables) {
    tables.limits = {};
    return tables;
}

}  // namespace

Subject::Subject(const std::filesystem::path& folder, Tables tables)
    : folder_(folder),
      tables_(unlimited(std::move(tables))),
      servo_(build_model(tables_)),
      model_(model_in_memory(tables_, servo_)) {}

std::size_t Subject::table_bytes() const { return flash_bytes(servo_); }

double Subject::height(double x, double y) const {
    double highest = -HUGE_VAL;
    for (const auto& patch : tables_.patch) {
        std::array<Vector3d, 3> v;
        for (std::size_t c = 0; c < 3; ++c) v[c] = vector(tables_.position[static_cast<std::size_t>(patch[c])]);
        const auto twice_area = [&](const Vector3d& a, const Vector3d& b) {
            return (a.x() - x) * (b.y() - y) - (a.y() - y) * (b.x() - x);
        };
        const Vector3d area(twice_area(v[1], v[2]), twice_area(v[2], v[0]), twice_area(v[0], v[1]));
        if (area.sum() <= 0.0 || area.minCoeff() < 0.0) continue;  // seen from below, or beside
        highest = std::max(highest, (area[0] * v[0].z() + area[1] * v[1].z() + area[2] * v[2].z()) / area.sum());
    }
    if (highest == -HUGE_VAL) throw Error(folder_.string() + ": no touchable patch over the bench's circle");
    return highest;
}

FingerPath Subject::circle(double depth_m, std::size_t ticks) const {
    Eigen::AlignedBox3d box;
    for (const auto& patch : tables_.patch)
        for (std::int32_t node : patch) box.extend(vector(tables_.position[static_cast<std::size_t>(node)]));
    const double radius = 0.2 * std::min(box.sizes().x(), box.sizes().y());
    FingerPath path;
    for (std::size_t i = 0; i < ticks; ++i) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(ticks);
        const double x = box.center().x() + radius * std::cos(angle);
        const double y = box.center().y() + radius * std::sin(angle);
        const Eigen::Vector3f at = Vector3d(x, y, height(x, y) - depth_m).cast<float>();
        path.push_back({at.x(), at.y(), at.z()});
    }
    return path;
}

haptable_servo Subject::touched(const FingerPath& path) const {
    haptable_servo servo{};
    haptable_output out{};
    haptable_servo_init(&servo);
    std::array<float, 3> above = path.front();
    above[2] = static_cast<float>(height(static_cast<double>(above[0]), static_cast<double>(above[1]))) + 0.001F;
    haptable_servo_step(&model_, &servo, above.data(), 0, &out);
    haptable_servo_step(&model_, &servo, path.front().data(), 0, &out);
    return servo;
}

}  // namespace haptable
