// SPDX-License-Identifier: GPL-2.0-or-later
// |P - A|^2 = |P - B|^2 = L^2, A and B the elbows: the end is on the elbows' bisector. Differentiated with A' = l t_1
// and B' = l t_2 of the motors: (P - A) . P' = (P - A) . A' and (P - B) . P' = (P - B) . B'.
#include "host/device/five_bar.hpp"

#include <Eigen/LU>
#include <cmath>

namespace haptable {

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Vector2d direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
Vector2d across(double angle) { return {-std::sin(angle), std::cos(angle)}; }

// A part of a right angle, where the two lower arms are nearly one line: beyond it a small force takes a large torque.
constexpr double kInALine = 1e-3;

}  // namespace

std::optional<Vector2d> FiveBar::end_m(const Vector2d& angle) const {
    const Vector2d a = upper_m * direction(angle[0]), b = Vector2d(base_m, 0.0) + upper_m * direction(angle[1]);
    const Vector2d between = b - a;
    const double distance_m = between.norm(), half_m = 0.5 * distance_m;
    if (!(distance_m > 0.0) || !(half_m < lower_m)) return std::nullopt;
    const Vector2d sideways = Vector2d(-between.y(), between.x()) / distance_m;
    return a + 0.5 * between + std::sqrt(lower_m * lower_m - half_m * half_m) * sideways;
}

std::optional<Matrix2d> FiveBar::jacobian(const Vector2d& angle) const {
    const std::optional<Vector2d> end = end_m(angle);
    if (!end) return std::nullopt;
    Matrix2d along;  // the lower arms' directions
    along.row(0) = (*end - upper_m * direction(angle[0])).transpose() / lower_m;
    along.row(1) = (*end - Vector2d(base_m, 0.0) - upper_m * direction(angle[1])).transpose() / lower_m;
    if (std::abs(along.determinant()) < kInALine) return std::nullopt;
    const Vector2d speed(along.row(0).dot(upper_m * across(angle[0])), along.row(1).dot(upper_m * across(angle[1])));
    return along.inverse() * speed.asDiagonal();
}

}  // namespace haptable
