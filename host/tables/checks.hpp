// SPDX-License-Identifier: GPL-2.0-or-later
// What tables.json of haptable-precompute tells of the force and of the mesh.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/tables/folder.hpp"

namespace haptable {

/// Depth, m, from which the force of these tables is expected to be more than 10 % off a rubber's, as tables.json of
/// haptable-precompute tells it; none where it does not. Throws Error where there are no tables.
std::optional<double> read_small_strain_depth(const TablesFolder& folder);

/// What haptable-precompute found wrong with a mesh.
struct MeshCheck {
    struct Element {
        std::uint64_t number = 0;  ///< in the mesh's file
        double radius_ratio = 0.0;
        std::array<std::int32_t, 4> node{};  ///< mesh nodes
    };
    std::vector<Element> worst;                           ///< the worst first
    std::vector<std::array<std::int32_t, 2>> hinge_edge;  ///< mesh nodes; the first ones where there are many
    std::vector<std::int32_t> hinge_node;
};

/// The check of tables in `folder`. Where tables.json tells none (of an earlier version) or names nodes that there
/// are not: none.
MeshCheck read_mesh_check(const TablesFolder& folder, std::size_t node_count);

}  // namespace haptable
