// SPDX-License-Identifier: GPL-2.0-or-later
// The body itself, for a box: 27-node hexahedra with a linear pressure in each (they do not lock), on a graded grid.
// Shares no element, no mesh and no load with what it judges.
#pragma once

#include <array>
#include <vector>

#include "host/bench/error/footprint.hpp"
#include "host/fem/elasticity.hpp"

namespace haptable {

/// Planes of the grid along x, y and z, m, ascending.
using GridPlanes = std::array<std::vector<double>, 3>;

/// Planes from low to high: `inner` cells of equal size within [from, to], and on either side `outer` that grow.
std::vector<double> graded_planes(double low, double high, double from, double to, int inner, int outer);

struct Box {
    GridPlanes plane_m;
    bool quarter = false;  ///< its planes of least x and y are planes of symmetry
};

/// How far a box gives, held at its lowest plane, under each footprint on its highest: C, m/N. Of a quarter box only
/// C_zz counts, and is the whole box's.
std::vector<Eigen::Matrix3d> brick_compliances(const Box& box, const Lame& material,
                                               std::span<const Footprint> footprints);

/// Rows and columns of these unknowns become those of the identity.
void hold(const std::vector<char>& held, Eigen::SparseMatrix<double>& k);

}  // namespace haptable
