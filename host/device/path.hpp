// SPDX-License-Identifier: GPL-2.0-or-later
// Where the hand wants the finger, or a tool's handle, to be: poke, drag, circle, roll and tilt as minimum-jerk
// movements, or a recorded path.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "host/device/point_device.hpp"
#include "host/link/finger_path.hpp"

namespace haptable {

/// The geometry of a scripted path. The defaults suit the paper's cube: its top's centre, pressed down; haptable-device
/// takes the place from the scene's tables (touchable.hpp).
struct PathOptions {
    Eigen::Vector3d at_m{0.015, 0.015, 0.030};        ///< where the surface is touched
    Eigen::Vector3d direction{0.0, 0.0, -1.0};        ///< into the body; any length but zero
    Eigen::Vector3d along = Eigen::Vector3d::Zero();  ///< of the drag; zero: a direction of its own choice
    double depth_m = 0.005;                           ///< of the goal below `at`: the finger stays less deep
    double radius_m = 0.005;                          ///< of the circle; half the length of the drag
    double clearance_m = 0.010;                       ///< of the start above `at`
    double speed_m_s = 0.05;                          ///< mean speed of every movement
    double hold_s = 0.2;                              ///< of a poke, at full depth; of a lift, above
    double lift_m = 0.03;                             ///< of a lift, along z
    double turn_deg = 15.0;                           ///< of roll and tilt, to each side
    double reach_m = 0.0;                             ///< of a tool: from its handle to the point that touches
};

class Path {
public:
    virtual ~Path() = default;
    virtual double duration_s() const = 0;
    /// The goal at a time. Before the path it waits at its beginning, after it at its end.
    virtual HandGoal at(double time_s) const = 0;
};

/// "poke", "drag", "circle", "lift" (in, up, down, out: for two hands), "roll" and "tilt" (in, a tool turned to and fro
/// about `along`, or across it, where it touches, out), or several with commas between them, one after the other. A
/// tool's -z points into the body. Throws Error for another name or an impossible geometry.
std::unique_ptr<Path> scripted_path(const std::string& names, const PathOptions& options);

/// The lines of a path in which that finger, 0 or 1, has a place, as those of one finger.
std::vector<FingerTick> ticks_of(const std::vector<FingerTick>& ticks, std::size_t finger);

/// Positions, one a millisecond, joined by straight lines, and their buttons. Throws Error when there are none.
std::unique_ptr<Path> recorded_path(std::vector<FingerTick> ticks);

}  // namespace haptable
