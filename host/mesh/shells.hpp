// SPDX-License-Identifier: GPL-2.0-or-later
// Parts of a surface, and which of them look into a cavity.
#pragma once

#include <map>

#include "host/mesh/surface.hpp"

namespace haptable {

/// Patches at each edge (its mesh nodes, the lower one first).
using Edges = std::map<std::array<std::int32_t, 2>, std::vector<std::size_t>>;
Edges edges_of(const std::vector<Patch>& patches);

/// Parts of a surface that share no edge.
struct Shells {
    std::vector<std::size_t> of_patch;  ///< [q] shell of each patch
    std::vector<double> volume_m3;      ///< enclosed by each shell, by the divergence theorem

    /// A shell whose patches look inwards encloses emptiness: its volume is negative.
    bool is_cavity(std::size_t shell) const { return volume_m3[shell] < 0.0; }
};
/// edges: of the surface's patches.
Shells find_shells(const TetMesh& mesh, const Surface& surface, const Edges& edges);

}  // namespace haptable
