// SPDX-License-Identifier: GPL-2.0-or-later
// [tool]: a rigid tool that a hand holds, by its points or by a shape.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

namespace haptable {

/// A side of a shape, which faces along the tool's -z. Its handle is the origin of its axes.
struct ToolShape {
    enum class Kind {
        kSphere,   ///< about the handle
        kCapsule,  ///< a cylinder along x with half a sphere at each end, about the handle
        kDisc,     ///< flat, in the plane z = 0
        kMesh      ///< triangles of a file, in the file's frame
    };
    Kind kind = Kind::kSphere;
    int points = 0;           ///< 2 to 32
    double radius_m = 0.0;    ///< of sphere, capsule, disc
    double length_m = 0.0;    ///< of a capsule, between the centres of its ends
    double angle_deg = 60.0;  ///< between -z and the normal of what is sampled, at most; of a disc unused
    std::filesystem::path file{};
    double scale_m = 1.0;  ///< metres per unit of the file
};

/// Points that touch, held by one hand. What is 0 is not given.
struct Tool {
    std::vector<std::array<double, 3>> point_m;  ///< about the handle, in the tool's axes; of a shape as it is sampled
    std::optional<ToolShape> shape;
    double max_torque_n_m = 0.0;              ///< of the motors
    double stiffness_n_per_m = 0.0;           ///< of a virtual coupling between hand and tool
    double turn_stiffness_n_m_per_rad = 0.0;  ///< the same about the handle
    int line = 0;                             ///< of [tool] in the scene file, for errors
};

}  // namespace haptable
