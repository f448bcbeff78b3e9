// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/middles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "host/base/error.hpp"
#include "host/base/index.hpp"
#include "host/mesh/quadratic_tet.hpp"
#include "host/mesh/surface.hpp"

namespace haptable {

namespace {

/// surface: of the corners alone.
void extend(MeshGroup& group, const std::vector<Patch>& surface, const TetMesh& mesh, const Middles& middles) {
    std::vector<std::int32_t> made;
    for (std::int32_t t : group.tet) made.insert(made.end(), mesh.middle[at(t)].begin(), mesh.middle[at(t)].end());
    const auto add_edges = [&](const Patch& patch, auto belongs) {
        for (std::size_t c = 0; c < 3; ++c) {
            const std::int32_t a = patch[c], b = patch[(c + 1) % 3];
            if (const std::int32_t middle = middles.find(a, b); middle >= 0 && belongs(a, b)) made.push_back(middle);
        }
    };
    for (const Patch& triangle : group.triangle) add_edges(triangle, [](std::int32_t, std::int32_t) { return true; });
    // Nodes alone do not tell what lies between them.
    const bool has_nodes_only = group.triangle.empty() && group.tet.empty();
    const auto has = [&](std::int32_t i) { return std::binary_search(group.node.begin(), group.node.end(), i); };
    for (const Patch& patch : surface)
        add_edges(patch, [&](std::int32_t a, std::int32_t b) { return has_nodes_only && has(a) && has(b); });
    std::sort(made.begin(), made.end());
    made.erase(std::unique(made.begin(), made.end()), made.end());
    group.node.insert(group.node.end(), made.begin(), made.end());  // behind all corners: still ascending
}

}  // namespace

std::int32_t Middles::of(std::int32_t a, std::int32_t b) {
    const auto [found, is_new] = node_.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(position_m_.size()));
    if (is_new) position_m_.push_back(0.5 * (position_m_[at(a)] + position_m_[at(b)]));
    return found->second;
}

std::int32_t Middles::find(std::int32_t a, std::int32_t b) const {
    const auto found = node_.find(std::minmax(a, b));
    return found == node_.end() ? -1 : found->second;
}

void add_middles(TetMesh& mesh) {
    const std::vector<Patch> surface = find_surface(mesh.tet).patch;
    Middles middles(mesh.position_m);
    for (const Tet& tet : mesh.tet) {
        MiddleNodes& middle = mesh.middle.emplace_back();
        for (std::size_t e = 0; e < 6; ++e) middle[e] = middles.of(tet[kTetEdges[e][0]], tet[kTetEdges[e][1]]);
        if (mesh.position_m.size() > at(std::numeric_limits<std::int32_t>::max()) / 3)
            throw Error(
                fmt::format("the mesh has {} tetrahedra: with nodes in the middle of their edges it has more "
                            "than can be numbered; use a coarser mesh or another mesh.element",
                            mesh.tet.size()));
    }
    for (auto& [name, group] : mesh.group) extend(group, surface, mesh, middles);
}

void turn(Tet& tet, MiddleNodes& middle) {
    std::swap(tet[2], tet[3]);
    std::swap(middle[1], middle[4]);  // 12, 13
    std::swap(middle[2], middle[3]);  // 20, 03
}

}  // namespace haptable
