// SPDX-License-Identifier: GPL-2.0-or-later
// C(g) of a contact point or mask, as the polynomial on every patch that the servo evaluates.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/precompute/compliance.hpp"
#include "host/precompute/mask.hpp"

namespace haptable {

/// The blocks of force = "pressure-mask", m/N: C(alpha) of degree 4 in Bernstein's form, symmetric.
/// t vertices, e edges, p patches, as in Masks and in the list of patches.
struct MaskCompliance {
    std::vector<Eigen::Matrix3d> vertex;                ///< [t] exponent 4 at the vertex
    std::vector<std::array<Eigen::Matrix3d, 3>> edge;   ///< [e] exponents 31, 22, 13 from the lower node
    std::vector<std::array<Eigen::Matrix3d, 3>> patch;  ///< [p] exponent 2 at corner 0, 1, 2 and 1 at the others
    double largest_residual = 0.0;                      ///< of the solves
};

/// C = w^T L w with the masks' w, from solves for every node that is under a mask. A fixed node adds no compliance.
///   unknown [N] place of a mesh node among the unknowns, -1 where it is held
MaskCompliance compute_mask_compliance(const LinearSolver& solver, const Eigen::SparseMatrix<double>& k,
                                       const Masks& masks, std::span<const std::array<std::int32_t, 3>> patch,
                                       std::span<const std::int32_t> unknown, Progress& progress);

}  // namespace haptable
