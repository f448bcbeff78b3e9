// SPDX-License-Identifier: GPL-2.0-or-later
// w_a(g): how a finite contact's load is distributed over the surface's nodes (after James and Pai's vertex pressure
// masks).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/base/progress.hpp"
#include "host/base/workers.hpp"
#include "host/mesh/surface.hpp"

namespace haptable {

/// Weights of nodes, ascending by node; their sum is 1.
struct NodeWeights {
    std::vector<std::int32_t> node;
    std::vector<double> weight;
};

/// The masks of a surface as a quadratic function on every patch, in Bernstein's form:
/// w(g) = sum_v alpha_v^2 vertex[v] + sum_{edges (v, w)} 2 alpha_v alpha_w edge[(v, w)].
/// At a vertex and in an edge's middle it is k(d) A_a, normed, with d the distance over the surface, A_a the node's
/// (mixed Voronoi) area and k = (1 - (d / radius)^2)^2; between, the quadratic keeps the mask's second moments. Where
/// no other node is within the radius, the patch's own nodes carry the load: w is alpha, continuously.
/// On quadratic tetrahedra the pressure k(d) is integrated against the shape functions of their faces: a node's share
/// of it may be 0 or less, for a corner's of an even pressure is 0.
struct Masks {
    std::vector<std::int32_t> vertex_id;               ///< [t] mesh nodes of the patches, ascending
    std::vector<std::array<std::int32_t, 2>> edge_id;  ///< [e] mesh nodes of their edges, lower first, ascending
    std::vector<NodeWeights> vertex;                   ///< [t]
    std::vector<NodeWeights> edge;                     ///< [e]
    /// [p] control masks of each patch: its vertices, then the edges opposite to them. Edges are numbered after all
    /// vertices.
    std::vector<std::array<std::size_t, 6>> control;
    std::size_t most_nodes = 0;  ///< under the mask of any point
    std::size_t widened = 0;     ///< vertices and edges with no node within reach but their own

    const NodeWeights& weights(std::size_t k) const { return k < vertex.size() ? vertex[k] : edge[k - vertex.size()]; }
};

/// Mesh nodes and edges of patches, as Masks holds them.
std::vector<std::int32_t> nodes_of(std::span<const std::array<std::int32_t, 3>> patch);
std::vector<std::array<std::int32_t, 2>> sorted_edges(std::span<const std::array<std::int32_t, 3>> patch);

/// The workers share the vertices and edges; their number changes no bit.
///   quarter  [p] of quadratic tetrahedra; else empty
Masks make_masks(std::span<const Eigen::Vector3d> position_m, std::span<const std::array<std::int32_t, 3>> patch,
                 double radius_m, Workers& workers, Progress& progress, std::span<const Quarter> quarter = {});

}  // namespace haptable
