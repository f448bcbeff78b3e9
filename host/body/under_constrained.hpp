// SPDX-License-Identifier: GPL-2.0-or-later
// What makes K singular: parts of the body that can move without deforming.
#pragma once

#include "host/body/body.hpp"
#include "host/inverse/stiffness.hpp"

namespace haptable {

/// The mesh nodes, ascending, that can move while no tetrahedron deforms; empty where the body is fully constrained.
/// Found from the mesh alone: tetrahedra that share a face move as one rigid part, parts that share only nodes hang on
/// hinges. With more than 64 such parts only those without any connection to a fixed node or a bed are found: the
/// pivots of the factorisation tell the rest.
std::vector<std::int32_t> find_under_constrained(const Body& body);

/// What fixes one body (tetrahedra that hang together by nodes).
struct Support {
    std::size_t nodes = 0, tets = 0, fixed_nodes = 0;
    std::size_t bed_faces = 0;
    bool is_constrained = true;  ///< no node of it is under-constrained
};
/// One for every body, in the order of their first nodes. under_constrained: as find_under_constrained() gives them.
std::vector<Support> find_supports(const Body& body, const std::vector<std::int32_t>& under_constrained);

/// The unknown nodes, ascending, that move in the softest motion of a K whose factorisation met a pivot that is zero
/// to rounding: by inverse iteration on K plus a small multiple of its diagonal.
std::vector<std::int32_t> find_softest_nodes(const Stiffness& k);

/// "47 nodes are under-constrained (...)": which mesh nodes, where they lie and what to fix.
std::string describe_under_constrained(const std::vector<std::int32_t>& nodes, const Body& body);

}  // namespace haptable
