// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/energy.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

/// 0 where the load is not a number: then the servo gave no force either.
double stored(const std::array<float, 3>& inside_m, const haptable_output& output) {
    double sum_j = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double load_n = 0.0;
        for (const auto& nodal_force_n : output.nodal_force_n) load_n += double{nodal_force_n[axis]};
        sum_j += 0.5 * load_n * (double{inside_m[axis]} - double{output.god_object_m[axis]});
    }
    return std::isfinite(sum_j) ? sum_j : 0.0;
}

Eigen::Quaterniond quaternion(const std::array<float, 4>& turn) {
    return {double{turn[0]}, double{turn[1]}, double{turn[2]}, double{turn[3]}};
}

/// Torque times the rotation from one tick to the next, J: a small angle, whose sine is the angle to the third order.
double turned(const ToolWork& before, const std::array<float, 4>& now) {
    const Eigen::Quaterniond by = quaternion(now) * quaternion(before.turn).conjugate();
    return (by.w() < 0.0 ? -2.0 : 2.0) * by.vec().dot(Eigen::Vector3f(before.torque_n_m.data()).cast<double>());
}

}  // namespace

void EnergyAccount::add(const std::array<float, 3>& finger_m, const haptable_output& output,
                        const std::array<float, 3>& inside_m, const ToolWork* tool) {
    const std::optional<Held> before = std::exchange(last_, std::nullopt);
    stored_j_ = 0.0;
    if (haptable_touches(output.state) == 0 && output.state != HAPTABLE_FREE) return;
    last_ = Held{finger_m, {output.force_n[0], output.force_n[1], output.force_n[2]}, {}};
    if (tool != nullptr) last_->tool = *tool;
    if (haptable_touches(output.state) != 0) stored_j_ = tool != nullptr ? tool->stored_j : stored(inside_m, output);
    most_stored_j_ = std::max(most_stored_j_, stored_j_);
    for (std::size_t axis = 0; before && axis < 3; ++axis)
        given_j_ += double{before->force_n[axis]} * (double{finger_m[axis]} - double{before->finger_m[axis]});
    if (before && tool != nullptr) given_j_ += turned(before->tool, tool->turn);
    most_given_j_ = std::max(most_given_j_, given_j_);
}

void ForceReport::note(const std::array<float, 3>& finger_m, const haptable_output& output,
                       const std::array<float, 3>& inside_m, const ToolWork* tool) {
    const float* force_n = output.force_n;
    largest_force_n = std::max(largest_force_n, std::hypot<double>(force_n[0], force_n[1], force_n[2]));
    energy.add(finger_m, output, inside_m, tool);
}

void ForceReport::add_to(SummaryLines& summary, const std::string& suffix) const {
    summary.add("largest_force_n" + suffix, largest_force_n);
    for (const auto& [name, energy_j] : energy.by_name()) summary.add(fmt::format("{}_j{}", name, suffix), energy_j);
}

}  // namespace haptable
