// SPDX-License-Identifier: GPL-2.0-or-later
// C(g) of a contact point or mask, as the polynomial on every patch that the servo evaluates.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/inverse/selected_inversion.hpp"
#include "host/precompute/mask.hpp"

namespace haptable {

/// The blocks of force = "pressure-mask", m/N: C(alpha) of degree 4 in Bernstein's form, symmetric.
/// t vertices, e edges, p patches, as in Masks and in the list of patches.
struct MaskCompliance {
    std::vector<Eigen::Matrix3d> vertex;                ///< [t] exponent 4 at the vertex
    std::vector<std::array<Eigen::Matrix3d, 3>> edge;   ///< [e] exponents 31, 22, 13 from the lower node
    std::vector<std::array<Eigen::Matrix3d, 3>> patch;  ///< [p] exponent 2 at corner 0, 1, 2 and 1 at the others
};

/// Pairs of unknown nodes whose L_ij the masks need: those that are under one patch's control masks. Each pair once,
/// ascending. A fixed node adds no compliance.
///   unknown [N] place of a mesh node among the unknowns, -1 where it is fixed
std::vector<NodePair> mask_pairs(const Masks& masks, std::span<const std::array<std::int32_t, 3>> patch,
                                 std::span<const std::int32_t> unknown);

/// C = w^T L w with the masks' w.
///   l_ij  blocks of mask_pairs(), in that order, m/N
MaskCompliance compute_mask_compliance(const Masks& masks, std::span<const std::array<std::int32_t, 3>> patch,
                                       std::span<const std::int32_t> unknown, std::span<const Eigen::Matrix3d> l_ij);

}  // namespace haptable
