// SPDX-License-Identifier: GPL-2.0-or-later
// A surface as its file has it, and whether it bounds a body.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "host/mesh/raw_mesh.hpp"

namespace haptable {

/// P points, F triangles; nothing is promised about how they fit together.
struct Soup {
    std::vector<Eigen::Vector3d> point;                ///< [P] in units of the file
    std::vector<std::array<std::size_t, 3>> triangle;  ///< [F] points
};

/// Edges that keep a surface from bounding a body. An edge of a closed surface has two triangles, which run along it in
/// opposite directions.
struct BadEdges {
    std::size_t open = 0;          ///< one triangle
    std::size_t non_manifold = 0;  ///< three or more
    std::size_t flipped = 0;       ///< ways along an edge that two or more triangles go: one is turned inside out
    std::size_t edges = 0;         ///< of any kind
    std::string first;             ///< where the first open or non-manifold one is
};

/// Makes points one that are nearer to each other than a millionth of the box's diagonal (an STL file repeats every
/// corner, rounded), and drops the triangles that collapse by it and the points that no triangle has.
/// Returns how many triangles were dropped.
std::size_t weld(Soup& soup);

/// The file's triangles, welded. Returns how many of them had no area and were left out.
std::size_t to_soup(const RawMesh& raw, Soup& soup);

BadEdges find_bad_edges(const Soup& soup);

/// "14980 vertices, 29956 triangles, 1 part, 0 open, 0 non-manifold and 0 flipped edges, Euler characteristic 2,
/// 60.4 x 136 x 51.2 long, volume 1.35e+05 (units of the file)", of a surface that was welded.
std::string describe(const Soup& soup);

}  // namespace haptable
