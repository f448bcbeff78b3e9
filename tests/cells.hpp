// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies of cells, each cut into six tetrahedra, and one of slivers.
#pragma once

#include <functional>

#include "host/mesh/mesh.hpp"

namespace haptable::test {

/// A body of cells that are cut into six tetrahedra each. `at` maps the grid (0..nx, 0..ny, 0..nz) to metres; points
/// that fall together are one node; `solid` says which cells there are. Its nodes with `held` are fixed.
struct Cells {
    std::array<int, 3> count;
    std::function<Eigen::Vector3d(double, double, double)> at;
    std::function<bool(int, int, int)> solid;
    std::function<bool(const Eigen::Vector3d&)> held;
};

TetMesh mesh_of(const Cells& cells);

/// A cube of 30 mm in two layers of n by n cells whose diagonals do not meet: on each face between them lies a sliver,
/// four nodes near the corners of a square, of this radius ratio (three inradii over the circumradius).
TetMesh sliver_mesh(int n, double radius_ratio);

/// A height below which a tenth of its nodes lies.
double lowest_tenth_m(const TetMesh& mesh);

}  // namespace haptable::test
