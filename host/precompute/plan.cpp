// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/plan.hpp"

#include <algorithm>
#include <set>

#include "host/compliance/point_compliance.hpp"

namespace haptable {

namespace {

using Nodes = std::vector<std::int32_t>;

Nodes unknowns_of(const Nodes& mesh_nodes, const Body& body) {
    Nodes unknowns;
    for (std::int32_t node : mesh_nodes) unknowns.push_back(body.unknown[static_cast<std::size_t>(node)]);
    return unknowns;
}

bool has_all(const Nodes& place) { return std::count(place.begin(), place.end(), -1) == 0; }

void plan_blocks(const Scene& scene, const Body& body, Plan& plan) {
    for (std::size_t i = 0; i < plan.node.size(); ++i)
        if (plan.block_place[i] < 0) plan.blocks.push_back({plan.node[i], plan.node[i]});
    plan.l_ii_count = plan.blocks.size();
    for (const auto& edge : coupled_edges(scene, body)) {
        const Nodes end = unknowns_of({edge[0], edge[1]}, body);
        plan.blocks.push_back({end[0], end[1]});
    }
}

void plan_columns(Plan& plan) {
    std::set<std::int32_t> has_column;
    for (std::size_t i = 0; i < plan.node.size(); ++i)
        if (plan.column_place[i] >= 0) {
            has_column.insert(plan.node[i]);
        } else {
            plan.column_node.push_back(plan.node[i]);
            plan.column_places.node.push_back(i);
        }
    for (std::size_t k = 0; k < plan.row.size(); ++k)
        if (has_column.count(plan.row[k]) == 0) {
            plan.column_row.push_back(plan.row[k]);
            plan.column_places.row.push_back(k);
        }
}

}  // namespace

const Nodes& rows_of(const Scene& scene, const Body& body) {
    return scene.tables.columns == ColumnRows::kAll ? body.free_node : body.free_surface_node;
}

double column_bytes(const Scene& scene, const Body& body) {
    const double entry = scene.tables.column_precision == Storage::kFloat16 ? sizeof(Half) : sizeof(float);
    return static_cast<double>(body.touch_node.size()) * static_cast<double>(rows_of(scene, body).size()) * 9.0 * entry;
}

Drawing drawing_of(const Scene& scene, const Body& body) {
    if (scene.tables.columns == ColumnRows::kNone) return Drawing::kNone;
    // The target's own display is made from columns.
    const bool fits = column_bytes(scene, body) <= scene.tables.column_budget_bytes;
    return fits || !scene.tables.display_rows.empty() ? Drawing::kColumns : Drawing::kSolves;
}

std::string name_of(Drawing drawing) {
    return drawing == Drawing::kNone ? "none" : drawing == Drawing::kColumns ? "columns" : "solves";
}

std::vector<std::array<std::int32_t, 2>> coupled_edges(const Scene& scene, const Body& body) {
    std::vector<std::array<std::int32_t, 2>> edges;
    if (scene.contact.force != ForceLaw::kConsistent) return edges;
    for (const auto& edge : sorted_edges(body.touch_patch))
        if (!body.is_fixed(edge[0]) && !body.is_fixed(edge[1])) edges.push_back(edge);
    return edges;
}

bool Plan::is_complete() const {
    return has_all(block_place) && (drawing != Drawing::kColumns || has_all(column_place)) &&
           (drawing != Drawing::kSolves || earlier.has_factor());
}

Plan make_plan(const Scene& scene, const Body& body, Drawing drawing, const Identity& identity,
               const std::filesystem::path& folder, bool force) {
    Plan plan;
    plan.drawing = drawing;
    plan.node = unknowns_of(body.touch_node, body);
    if (drawing == Drawing::kColumns) plan.row = unknowns_of(rows_of(scene, body), body);
    if (!force)
        plan.earlier = EarlierTables(folder, identity, rows_of(scene, body), word(scene.tables.column_precision));
    const Nodes none(plan.node.size(), -1), place = plan.earlier.places_of(body.touch_node);
    // The other forces need more than the L_ii, and then get these with the rest.
    plan.block_place = plan.earlier.has_blocks() && scene.contact.force == ForceLaw::kInterpolated ? place : none;
    plan.column_place = plan.earlier.has_columns() && drawing == Drawing::kColumns ? place : none;
    plan_blocks(scene, body, plan);
    plan_columns(plan);
    return plan;
}

Masks masks_of(const Body& body, double radius_m, Workers& workers, Progress& progress) {
    return make_masks(body.mesh.position_m, body.touch_patch, radius_m, workers, progress, body.touch_quarter);
}

void plan_masks(const Scene& scene, const Body& body, Workers& workers, Progress& progress, Plan& plan) {
    plan.masks = masks_of(body, scene.contact.mask_radius_m, workers, progress);
    plan.mask_pairs = mask_pairs(plan.masks, body.unknown, workers);
}

}  // namespace haptable
