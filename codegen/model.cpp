// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "codegen/laws.hpp"
#include "codegen/precision.hpp"
#include "firmware/haptable_model.h"
#include "host/base/error.hpp"
#include "host/base/noise.hpp"

namespace haptable {

namespace {

constexpr float kTolerance = 0x1p-20F;  // of the diagonal: eight times the rounding of a float coordinate
constexpr float kWorkspace = 20.0F;     // diagonals, and at least one metre: the workspace of any desktop device

/// Free touchable nodes in table order, then the fixed ones that their patches touch, ascending.
std::vector<std::int32_t> vertex_nodes(const Tables& tables) {
    std::vector<std::int32_t> nodes = tables.node_id;
    const std::set<std::int32_t> free(nodes.begin(), nodes.end());
    std::set<std::int32_t> fixed;
    for (const auto& corners : tables.patch)
        for (std::int32_t node : corners)
            if (!free.contains(node)) fixed.insert(node);
    nodes.insert(nodes.end(), fixed.begin(), fixed.end());
    return nodes;
}

void check_size(std::size_t count, const char* what) {
    if (count >= HAPTABLE_NONE)
        throw Error(
            fmt::format("the touchable surface has {} {}, more than the servo's {}: give [[touch]] regions or a "
                        "coarser mesh",
                        count, what, HAPTABLE_NONE - 1));
}

/// Going around a vertex must fit into one tick of the servo's walk.
void check_fans(const Tables& tables) {
    std::vector<std::size_t> patches(tables.position.size(), 0);
    for (const auto& corners : tables.patch)
        for (const std::int32_t node : corners) ++patches[static_cast<std::size_t>(node)];
    const auto most = std::max_element(patches.begin(), patches.end());
    if (*most > HAPTABLE_FAN_PATCHES)
        throw Error(
            fmt::format("{} touchable patches meet at node {}, more than the servo's {}: leave it out of the [[touch]] "
                        "regions, or mesh it with fewer slivers",
                        *most, most - patches.begin(), HAPTABLE_FAN_PATCHES));
}

float finite(double value, const char* what) {
    const auto narrow = static_cast<float>(value);
    if (!std::isfinite(narrow))
        throw Error(fmt::format("{} = {} does not fit a float: check units and material", what, value));
    return narrow;
}

std::vector<std::array<std::uint16_t, 3>> vertex_patches(const Tables& tables, const std::vector<std::int32_t>& nodes) {
    std::vector<std::uint16_t> vertex_of(tables.position.size(), HAPTABLE_NONE);
    for (std::size_t v = 0; v < nodes.size(); ++v)
        vertex_of[static_cast<std::size_t>(nodes[v])] = static_cast<std::uint16_t>(v);
    std::vector<std::array<std::uint16_t, 3>> patches;
    for (const auto& corners : tables.patch) {
        std::array<std::uint16_t, 3> patch{};
        for (std::size_t c = 0; c < 3; ++c) patch[c] = vertex_of[static_cast<std::size_t>(corners[c])];
        patches.push_back(patch);
    }
    return patches;
}

float diagonal(const std::vector<std::array<float, 3>>& points) {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto by_axis = [&](const auto& a, const auto& b) { return a[axis] < b[axis]; };
        const auto [low, high] = std::minmax_element(points.begin(), points.end(), by_axis);
        sum += std::pow(static_cast<double>((*high)[axis] - (*low)[axis]), 2);
    }
    return static_cast<float>(std::sqrt(sum));
}

/// A point's dent is as wide as an edge, a mask's as the mask.
double dent_reach_m(const Tables& tables) {
    double sum_m = 0.0;
    for (const auto& corners : tables.patch)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto& a = tables.position[static_cast<std::size_t>(corners[c])];
            const auto& b = tables.position[static_cast<std::size_t>(corners[(c + 1) % 3])];
            sum_m += std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
        }
    return std::max(tables.mask_radius_m, sum_m / (3.0 * static_cast<double>(tables.patch.size())));
}

void add_relaxation(const Tables& tables, ServoModel& model) {
    if (tables.relaxation.empty()) return;
    if (tables.relaxation.size() > HAPTABLE_TERMS)
        throw Error(fmt::format("{} [[relaxation]] terms are more than the servo's {}", tables.relaxation.size(),
                                HAPTABLE_TERMS));
    for (const RelaxationTerm& term : tables.relaxation) {
        const TickRelaxation tick = relaxation_of_tick(term);
        model.term.push_back(
            {static_cast<float>(term.share), static_cast<float>(tick.fall), static_cast<float>(tick.rise)});
    }
    model.relaxation_reach_m = finite(dent_reach_m(tables), "a length");
}

}  // namespace

std::vector<float> stiffening_table(const StiffeningCurve& curve) {
    std::vector<float> table;
    for (const double c : curve.c) table.push_back(finite(c, "a curve's number"));
    table.push_back(finite(0.5 / curve.energy_j, "a curve's energy"));
    return table;
}

std::array<float, 6> packed(const std::array<double, 9>& block, const char* what) {
    double size = 0.0;
    for (const double entry : block) size = std::max(size, std::abs(entry));
    const auto mean = [&](std::size_t a, std::size_t b) {
        return finite(without_noise(0.5 * (block[a] + block[b]), size), what);
    };
    return {mean(0, 0), mean(4, 4), mean(8, 8), mean(1, 3), mean(5, 7), mean(2, 6)};
}

ServoModel build_model(const Tables& tables) {
    ServoModel model;
    if (tables.patch.empty()) throw Error("no touchable patch: the servo has nothing to touch");
    model.node = vertex_nodes(tables);
    model.free_count = tables.node_id.size();
    check_size(model.node.size(), "nodes");
    check_size(tables.patch.size(), "patches");
    check_fans(tables);
    for (std::int32_t node : model.node) {
        const auto& x = tables.position[static_cast<std::size_t>(node)];
        model.vertex_m.push_back({finite(x[0], "a position"), finite(x[1], "a position"), finite(x[2], "a position")});
    }
    for (const auto& block : tables.stiffness) model.stiffness_n_per_m.push_back(packed(block, "a stiffness"));

    const auto patches = vertex_patches(tables, model.node);
    SpatialIndex index = build_index(model.vertex_m, patches);
    model.grid_origin_m = index.origin_m;
    model.grid_per_m = index.per_m;
    model.leaf_order = std::move(index.order);
    model.box = std::move(index.boxes);
    for (std::size_t old : model.leaf_order) model.patch.push_back(patches[old]);
    model.neighbour = build_neighbours(model.vertex_m, model.patch);
    model.hinge = build_hinges(model.vertex_m.size(), model.patch, model.neighbour);
    check_size(model.hinge.size(), "patches at hinges");
    const float size = diagonal(model.vertex_m);
    model.tolerance_m = size * kTolerance;
    model.workspace_limit_m = std::max(1.0F, kWorkspace * size);
    model.rigid_stiffness_n_per_m = finite(tables.rigid_stiffness_n_per_m, "rigid_stiffness");
    if (tables.compliance.degree != 0) model.compliance = build_compliance(tables, model);
    couple(tables, model);
    pack_blocks(tables.precision, model);
    add_relaxation(tables, model);
    if (tables.stiffening.energy_j > 0.0) model.stiffening = stiffening_table(tables.stiffening);
    return model;
}

}  // namespace haptable
