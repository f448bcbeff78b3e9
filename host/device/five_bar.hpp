// SPDX-License-Identifier: GPL-2.0-or-later
// The plane five-bar linkage of Haply's 2diy: two motors side by side, upper arms l, lower arms L that meet at the end.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace haptable {

/// Lengths in metres. The first motor is at (0, 0), the second at (base, 0); angles from the x axis; the end is on the
/// side to which the arms bend, y > 0 at rest.
struct FiveBar {
    double upper_m = 0.07, lower_m = 0.09, base_m = 0.0;

    /// Place of the end for the motors' angles, rad; none where the arms do not reach each other.
    std::optional<Eigen::Vector2d> end_m(const Eigen::Vector2d& angle) const;
    /// d(end)/d(angle), m/rad: the torques of a force F at the end are its transpose times F. None where the arms do
    /// not reach each other or stand in a line.
    std::optional<Eigen::Matrix2d> jacobian(const Eigen::Vector2d& angle) const;
};

}  // namespace haptable
