// SPDX-License-Identifier: GPL-2.0-or-later
// M_ab = int density N_a N_b dV I
#pragma once

#include "host/fem/stiffness.hpp"

namespace haptable {

/// The consistent mass of the unknown nodes, kg: [3n, 3n], both triangles. Exact on straight elements.
///   density  [T] kg/m^3
Eigen::SparseMatrix<double> mass_matrix(const ElementMesh& mesh, std::span<const double> density_kg_per_m3,
                                        std::span<const std::int32_t> unknown, std::int32_t unknown_count);

}  // namespace haptable
