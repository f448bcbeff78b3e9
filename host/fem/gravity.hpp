// SPDX-License-Identifier: GPL-2.0-or-later
// f_a = int density g N_a dV,   K_sigma,ab = int (g_a . sigma g_b) dV I
//
// What a body's own weight does: forces on its nodes, and the stiffness that the stress of a displacement adds to K
// (Bathe, Finite Element Procedures, 6.3: the initial stress matrix).
#pragma once

#include "host/fem/stiffness.hpp"

namespace haptable {

/// [3, N] N. density: [T] kg/m^3; acceleration: m/s^2.
Eigen::Matrix3Xd weight_of(const ElementMesh& mesh, std::span<const double> density_kg_per_m3,
                           const Eigen::Vector3d& acceleration_m_per_s2);

/// K_sigma of the unknown nodes, N/m, in the pattern of StiffnessParts::a: of the body's stress, what is averaged at
/// the nodes with it, and of its membranes. u: [3, N] m, the displacement that the stress is of; small.
Eigen::SparseMatrix<double> geometric_stiffness(const ElementMesh& mesh, const Eigen::Matrix3Xd& u,
                                                std::span<const std::int32_t> unknown, std::int32_t unknown_count);

}  // namespace haptable
