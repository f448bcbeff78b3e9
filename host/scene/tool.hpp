// SPDX-License-Identifier: GPL-2.0-or-later
// [tool]: the shape of a rigid tool that a hand holds.
#pragma once

#include <filesystem>
#include <string>

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
    int points = 12;          ///< 2 to 32
    double radius_m = 0.0;    ///< of sphere, capsule, disc
    double length_m = 0.0;    ///< of a capsule, between the centres of its ends
    double angle_deg = 60.0;  ///< between -z and the normal of what is sampled, at most; of a disc unused
    std::filesystem::path file{};
    double scale_m = 1.0;  ///< metres per unit of the file
};

}  // namespace haptable
