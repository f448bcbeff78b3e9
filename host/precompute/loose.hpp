// SPDX-License-Identifier: GPL-2.0-or-later
// What makes K singular: parts of the body that can move without deforming.
#pragma once

#include <Eigen/SparseCore>

#include "host/precompute/body.hpp"

namespace haptable {

/// The mesh nodes, ascending, that can move while no tetrahedron deforms; empty where the body is held. Found from
/// the mesh alone: tetrahedra that share a face move as one rigid part, parts that share only nodes hang on hinges.
/// With more than 64 such parts only those without any connection to a held node are found: the pivots of the
/// factorisation tell the rest.
std::vector<std::int32_t> find_loose_nodes(const Body& body);

/// Whether one body (tetrahedra that hang together by nodes) is held still.
struct Hold {
    std::size_t nodes = 0, tets = 0, held_nodes = 0;
    bool is_held = true;  ///< no node of it is loose
};
/// One for every body, in the order of their first nodes. loose: as find_loose_nodes gives it.
std::vector<Hold> find_holds(const Body& body, const std::vector<std::int32_t>& loose);

/// The unknown nodes, ascending, that move in the softest motion of a K whose factorisation met a pivot that is zero
/// to rounding: by inverse iteration on K plus a small multiple of its diagonal. k: lower triangle at least.
std::vector<std::int32_t> find_softest_nodes(const Eigen::SparseMatrix<double>& k);

/// "47 nodes are loose (...)": which mesh nodes, where they lie and what to hold still.
std::string describe_loose(const std::vector<std::int32_t>& loose, const Body& body);

}  // namespace haptable
