// SPDX-License-Identifier: GPL-2.0-or-later
// Where a scene's body may be touched, from its tables: where a path begins that names no place, and what to say of one
// that met nothing.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
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

/// The surface of the tables in `folder` (position.npy and patch.npy). Throws Error that names the file.
Touchable read_touchable(const std::filesystem::path& folder);

/// The tables_hash of the tables in `folder`, as the messages have it; 0 where there are none.
std::int64_t tables_hash_in(const std::filesystem::path& folder);

/// A place to press.
struct TouchPlace {
    Eigen::Vector3d at_m;       ///< on the surface
    Eigen::Vector3d direction;  ///< into the body, of length 1
    bool is_under_top = false;  ///< straight under the middle of the box's top; else the nearest place to it
};

/// Where the vertical through the middle of the surface's box meets it first from above, pressed straight down; where
/// it meets no patch from outside, the point nearest to the middle of the box's top, pressed along the inner normal.
TouchPlace top_of(const Touchable& body);

/// Places to pinch, around the body at two thirds of its height, so that what is lifted there hangs: the touchable
/// points nearest to as many places on the ellipse that its box holds, the first of them on the side along x or y,
/// whichever is the shorter way through. Pressed towards the middle; where a surface leans by more than 60 degrees,
/// along its inner normal.
std::vector<TouchPlace> sides_of(const Touchable& body, std::size_t count);

/// "the touchable surface lies in (x y z) to (x y z) m".
std::string where_it_is(const Touchable& body);

}  // namespace haptable
