// SPDX-License-Identifier: GPL-2.0-or-later
// What a run is to compute: what the scene asks for, without what an earlier run left that still holds.
#pragma once

#include "host/body/body.hpp"
#include "host/body/mask.hpp"
#include "host/compliance/column_store.hpp"
#include "host/precompute/earlier_tables.hpp"

namespace haptable {

/// How the viewer gets its displacements: from columns.npy, or by a solve for each frame where that is over the budget.
enum class Drawing { kNone, kColumns, kSolves };
Drawing drawing_of(const Scene& scene, const Body& body);
std::string name_of(Drawing drawing);

/// Mesh nodes whose displacements columns.npy gives.
const std::vector<std::int32_t>& rows_of(const Scene& scene, const Body& body);
/// Bytes of columns.npy.
double column_bytes(const Scene& scene, const Body& body);

/// Edges whose L_ij the consistent force needs: those between free touchable nodes, as mesh nodes, lower first.
std::vector<std::array<std::int32_t, 2>> coupled_edges(const Scene& scene, const Body& body);

/// n nodes of the table, r rows of columns.npy. Nodes without "mesh" are unknowns.
struct Plan {
    Drawing drawing = Drawing::kNone;
    EarlierTables earlier;
    std::vector<std::int32_t> node, row;                  ///< [n], [r]; no rows without columns
    std::vector<std::int32_t> block_place, column_place;  ///< [n] in the earlier tables; -1: to be computed
    std::vector<NodePair> blocks;                         ///< to be computed: L_ii, then L_ij of edges
    std::size_t l_ii_count = 0;                           ///< of `blocks`
    /// Columns that are to be computed: of nodes without one, at the rows that no earlier column gives by symmetry.
    std::vector<std::int32_t> column_node, column_row;
    ColumnPlaces column_places;  ///< theirs in the table
    Masks masks;
    std::vector<NodePair> mask_pairs;  ///< empty without a pressure mask

    /// Nothing is missing: neither K nor its factor is needed.
    bool is_complete() const;
    std::size_t reused_columns() const { return node.size() - column_node.size(); }
};

/// folder: of the earlier run. force: nothing of it is taken.
Plan make_plan(const Scene& scene, const Body& body, Drawing drawing, const Identity& identity,
               const std::filesystem::path& folder, bool force);

/// Masks of that radius on the touchable surface.
Masks masks_of(const Body& body, double radius_m, Workers& workers, Progress& progress);
/// The masks of force = "pressure-mask", and the pairs that they need.
void plan_masks(const Scene& scene, const Body& body, Workers& workers, Progress& progress, Plan& plan);

}  // namespace haptable
