// SPDX-License-Identifier: GPL-2.0-or-later
// Where a scene's body may be touched, from its tables: where a path begins that names no place, and what to say of one
// that met nothing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace haptable {

/// The touchable surface. N mesh nodes, p patches, counter-clockwise seen from outside.
struct Touchable {
    std::vector<Eigen::Vector3d> position_m;         ///< [N] rest positions
    std::vector<std::array<std::int32_t, 3>> patch;  ///< [p] mesh nodes
};

/// Of the tables in `folder` (position.npy and patch.npy). Throws Error that names the file.
Touchable read_touchable(const std::filesystem::path& folder);

/// A place to press.
struct TouchPlace {
    Eigen::Vector3d at_m;       ///< on the surface
    Eigen::Vector3d direction;  ///< into the body, of length 1
    bool is_under_top = false;  ///< straight under the middle of the box's top; else the nearest place to it
};

/// Where the vertical through the middle of the surface's box meets it first from above, pressed straight down; where
/// it meets no patch from outside, the point nearest to the middle of the box's top, pressed along the inner normal.
TouchPlace top_of(const Touchable& body);

/// "the touchable surface lies in (x y z) to (x y z) m".
std::string where_it_is(const Touchable& body);

}  // namespace haptable
