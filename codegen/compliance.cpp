// SPDX-License-Identifier: GPL-2.0-or-later
// C(alpha) in the servo's order: blocks of vertices, of edges from their lower vertex, and inside of patches.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"
#include "host/base/error.hpp"

namespace haptable {

namespace {

using NodePair = std::array<std::int32_t, 2>;
using Block = std::array<double, 9>;

constexpr const char* kWhat = "a compliance";
constexpr Block kNone{};  // a fixed node adds no compliance

/// L_ii = S_i^-1, through S as the tables have it.
Block inverse(const Block& s) {
    Block l{};
    const Eigen::Map<const Eigen::Matrix3d> stiffness(s.data());
    Eigen::Map<Eigen::Matrix3d>(l.data()) = stiffness.inverse();
    return l;
}

/// [v] of the consistent force: L_ii of the free vertices, which stand first, and nothing for the fixed ones.
std::vector<Block> consistent_vertices(const Tables& tables, const ServoModel& model) {
    std::vector<Block> blocks;
    for (const Block& s : tables.stiffness) blocks.push_back(inverse(s));
    blocks.resize(model.node.size(), kNone);
    return blocks;
}

std::vector<Block> mask_vertices(const ComplianceTables& tables, const ServoModel& model) {
    std::map<std::int32_t, std::size_t> place;
    for (std::size_t t = 0; t < tables.vertex_id.size(); ++t) place[tables.vertex_id[t]] = t;
    std::vector<Block> blocks;
    for (std::int32_t node : model.node) {
        const auto found = place.find(node);
        if (found == place.end()) throw Error(fmt::format("vertex_id.npy lacks node {}: make the tables again", node));
        blocks.push_back(tables.vertex[found->second]);
    }
    return blocks;
}

/// Which edge lies opposite to each corner.
std::vector<std::array<std::uint16_t, 3>> patch_edges(const ComplianceTables& tables, const ServoModel& model) {
    std::map<NodePair, std::size_t> place;
    for (std::size_t e = 0; e < tables.edge_id.size(); ++e) place[tables.edge_id[e]] = e;
    std::vector<std::array<std::uint16_t, 3>> patch_edge;
    for (const auto& corner : model.patch) {
        std::array<std::uint16_t, 3> edges{};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [low, high] = std::minmax(model.node[corner[(c + 1) % 3]], model.node[corner[(c + 2) % 3]]);
            const auto found = place.find(NodePair{low, high});
            if (found == place.end())
                throw Error(fmt::format("edge_id.npy lacks the edge {} {}: make the tables again", low, high));
            edges[c] = static_cast<std::uint16_t>(found->second);
        }
        patch_edge.push_back(edges);
    }
    return patch_edge;
}

std::vector<std::array<float, 6>> in_float(const std::vector<Block>& blocks) {
    std::vector<std::array<float, 6>> floats;
    for (const Block& block : blocks) floats.push_back(packed(block, kWhat));
    return floats;
}

}  // namespace

ExactCompliance exact_compliance(const Tables& tables, const ServoModel& model) {
    const ComplianceTables& from = tables.compliance;
    ExactCompliance to;
    to.vertex = from.degree == 2 ? consistent_vertices(tables, model) : mask_vertices(from, model);
    std::map<std::int32_t, std::size_t> vertex;
    for (std::size_t v = 0; v < model.node.size(); ++v) vertex[model.node[v]] = v;
    const auto per_edge = static_cast<std::size_t>(from.degree - 1);
    for (std::size_t e = 0; e < from.edge_id.size(); ++e) {
        const bool turned = vertex.at(from.edge_id[e][0]) > vertex.at(from.edge_id[e][1]);
        for (std::size_t i = 0; i < per_edge; ++i)
            to.edge.push_back(from.edge[per_edge * e + (turned ? per_edge - 1 - i : i)]);
    }
    if (from.degree == 4)
        for (std::size_t old : model.leaf_order)
            to.patch.insert(to.patch.end(), &from.patch[3 * old], &from.patch[3 * old] + 3);
    return to;
}

ServoCompliance build_compliance(const Tables& tables, const ServoModel& model) {
    const std::size_t edges = tables.compliance.edge_id.size();
    if (edges >= HAPTABLE_NONE)
        throw Error(
            fmt::format("the touchable surface has {} edges, more than the servo's {} with force = \"{}\": give "
                        "[[touch]] regions or a coarser mesh",
                        edges, HAPTABLE_NONE - 1, word(tables.force)));
    const ExactCompliance exact = exact_compliance(tables, model);
    ServoCompliance to;
    to.degree = static_cast<std::uint8_t>(tables.compliance.degree);
    to.edge_count = static_cast<std::uint16_t>(edges);
    to.vertex = in_float(exact.vertex);
    to.edge = in_float(exact.edge);
    to.patch = in_float(exact.patch);
    to.patch_edge = patch_edges(tables.compliance, model);
    return to;
}

}  // namespace haptable
