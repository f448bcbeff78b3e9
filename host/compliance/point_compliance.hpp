// SPDX-License-Identifier: GPL-2.0-or-later
// C(g) of a contact point or mask, as the polynomial on every patch that the servo evaluates.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/base/progress.hpp"
#include "host/base/workers.hpp"
#include "host/body/mask.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

/// The blocks of force = "pressure-mask", m/N: C(alpha) of degree 4 in Bernstein's form, symmetric.
/// t vertices, e edges, p patches, as in Masks and in the list of patches.
struct MaskCompliance {
    std::vector<Eigen::Matrix3d> vertex;                ///< [t] exponent 4 at the vertex
    std::vector<std::array<Eigen::Matrix3d, 3>> edge;   ///< [e] exponents 31, 22, 13 from the lower node
    std::vector<std::array<Eigen::Matrix3d, 3>> patch;  ///< [p] exponent 2 at corner 0, 1, 2 and 1 at the others
    double flops = 0.0;                                 ///< multiplications and additions of the dense products
};

/// Pairs of unknown nodes whose L_ij the masks need: those that are under one patch's control masks. Each pair once,
/// ascending, the lower node first. A fixed node adds no compliance.
///   unknown [N] place of a mesh node among the unknowns, ascending, -1 where it is fixed
std::vector<NodePair> mask_pairs(const Masks& masks, std::span<const std::int32_t> unknown, Workers& workers);

/// C = w^T L w with the masks' w. The number of workers changes no bit.
///   position_m [N] of mesh nodes
///   pair, l_ij  of mask_pairs() and their blocks in that order, m/N
MaskCompliance compute_mask_compliance(const Masks& masks, std::span<const Eigen::Vector3d> position_m,
                                       std::span<const std::int32_t> unknown, std::span<const NodePair> pair,
                                       std::span<const Eigen::Matrix3d> l_ij, Workers& workers, Progress& progress);

}  // namespace haptable
