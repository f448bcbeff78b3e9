// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "host/mesh/mesh.hpp"

namespace haptable {

/// The paper's cube: nodes_per_side^3 nodes, numbered x fastest, then y, then z, one corner at the origin, side_m long;
/// 5 tetrahedra a cell. Neighbouring cells are mirrored, so that the diagonals of a shared face meet. The cell at
/// the origin has its corner at the origin cut off by one tetrahedron. nodes_per_side >= 2.
TetMesh make_cube(int nodes_per_side, double side_m);

}  // namespace haptable
