// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/checks.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace haptable {

std::optional<double> read_small_strain_depth(const TablesFolder& folder) try {
    const auto found = folder.facts().find("small_strain");
    if (found == folder.facts().end() || found->is_null()) return {};
    return found->at("depth_m").get<double>();
} catch (const nlohmann::json::exception& error) {
    folder.fail("tables.json", std::string("is not of haptable-precompute (") + error.what() + ")");
}

MeshCheck read_mesh_check(const TablesFolder& folder, std::size_t node_count) try {
    const auto mesh = folder.facts().at("mesh");
    const auto known = [&](std::int32_t node) { return node >= 0 && static_cast<std::size_t>(node) < node_count; };
    MeshCheck check;
    for (const auto& element : mesh.at("worst_elements")) {
        MeshCheck::Element e{element.at("tetrahedron"), element.at("radius_ratio"), element.at("nodes")};
        if (std::all_of(e.node.begin(), e.node.end(), known)) check.worst.push_back(e);
    }
    for (const auto& edge : mesh.at("hinge_edges_at"))
        if (known(edge.at(0)) && known(edge.at(1))) check.hinge_edge.push_back({edge.at(0), edge.at(1)});
    for (const std::int32_t node : mesh.at("hinge_nodes_at"))
        if (known(node)) check.hinge_node.push_back(node);
    return check;
} catch (const nlohmann::json::exception&) {
    return {};
}

}  // namespace haptable
