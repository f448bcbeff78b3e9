// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/subject.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/error.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

Vector3d corner(const Tables& tables, std::int32_t node) {
    return Vector3d(tables.position[static_cast<std::size_t>(node)].data());
}

/// Of the uppermost patch over (x, y), m.
double height(const Tables& tables, double x, double y) {
    double highest = -HUGE_VAL;
    for (const auto& patch : tables.patch) {
        const std::array v{corner(tables, patch[0]), corner(tables, patch[1]), corner(tables, patch[2])};
        const auto twice_area = [&](const Vector3d& a, const Vector3d& b) {
            return (a.x() - x) * (b.y() - y) - (a.y() - y) * (b.x() - x);
        };
        const Vector3d area(twice_area(v[1], v[2]), twice_area(v[2], v[0]), twice_area(v[0], v[1]));
        if (area.sum() <= 0.0 || area.minCoeff() < 0.0) continue;  // seen from below, or beside
        highest = std::max(highest, (area[0] * v[0].z() + area[1] * v[1].z() + area[2] * v[2].z()) / area.sum());
    }
    if (highest == -HUGE_VAL) throw Error(tables.name + ": no touchable patch over the bench's circle");
    return highest;
}

}  // namespace

FingerPath circle(const Tables& tables, double depth_m, std::size_t ticks) {
    Eigen::AlignedBox3d box;
    for (const auto& patch : tables.patch)
        for (std::int32_t node : patch) box.extend(corner(tables, node));
    const double radius = 0.2 * std::min(box.sizes().x(), box.sizes().y());
    FingerPath path;
    for (std::size_t i = 0; i < ticks; ++i) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(ticks);
        const double x = box.center().x() + radius * std::cos(angle);
        const double y = box.center().y() + radius * std::sin(angle);
        const Eigen::Vector3f at = Vector3d(x, y, height(tables, x, y) - depth_m).cast<float>();
        path.push_back({at.x(), at.y(), at.z()});
    }
    return path;
}

haptable_servo touched(const haptable_model& model, const FingerPath& path) {
    haptable_servo servo{};
    haptable_output out{};
    haptable_servo_init(&servo);
    std::array<float, 3> above = path.front();
    above[2] += 0.004F;  // more than any path's depth
    haptable_servo_step(&model, &servo, above.data(), 0, &out);
    haptable_servo_step(&model, &servo, path.front().data(), 0, &out);
    return servo;
}

}  // namespace haptable
