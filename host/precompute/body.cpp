// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/body.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/read_mesh.hpp"

namespace haptable {

namespace {

using Flags = std::vector<char>;  // [N] one a node, 0 or 1

[[noreturn]] void fail(const Scene& scene, const Selection& selection, const std::string& what) {
    throw Error(fmt::format("{}:{}: {}", scene.file.string(), selection.line, what));
}

bool inside(const std::array<double, 6>& box_m, const Eigen::Vector3d& p) {
    for (std::size_t c = 0; c < 3; ++c) {
        const double x = p[static_cast<Eigen::Index>(c)];
        if (x < box_m[c] || x > box_m[c + 3]) return false;
    }
    return true;
}

std::string extent(const TetMesh& mesh) {
    Eigen::AlignedBox3d box_m;
    for (const Eigen::Vector3d& p : mesh.position_m) box_m.extend(p);
    return describe(box_m);
}

void mark_box(const Scene& scene, const Selection& selection, const char* key, const TetMesh& mesh, Flags& flags) {
    bool any = false;
    for (std::size_t i = 0; i < flags.size(); ++i)
        if (inside(*selection.box_m, mesh.position_m[i])) flags[i] = any = true;
    if (!any)
        fail(scene, selection,
             fmt::format("{}.box: no node lies in it; the mesh fills the box {}: move the box or mend the mesh's "
                         "scale",
                         key, extent(mesh)));
}

void mark_group(const Scene& scene, const Selection& selection, const char* key, const TetMesh& mesh, Flags& flags) {
    const auto group = mesh.group.find(selection.group);
    if (group == mesh.group.end() || group->second.node.empty()) {
        std::vector<std::string> names;
        for (const auto& [name, unused] : mesh.group) names.push_back(name);
        fail(scene, selection,
             fmt::format("{}.group: the mesh has no nodes in a group \"{}\"; its groups: {}", key, selection.group,
                         names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }
    for (std::int32_t node : group->second.node) flags[static_cast<std::size_t>(node)] = 1;
}

/// The nodes that any of the selections holds.
Flags mark(const Scene& scene, const std::vector<Selection>& selections, const char* key, const TetMesh& mesh) {
    Flags flags(mesh.position_m.size(), 0);
    for (const Selection& selection : selections)
        if (selection.box_m)
            mark_box(scene, selection, key, mesh, flags);
        else
            mark_group(scene, selection, key, mesh, flags);
    return flags;
}

/// A body of micrometres or of thousands of kilometres is a mistaken unit, and its numbers leave float32's range.
void require_size(const Scene& scene, const TetMesh& mesh) {
    constexpr double kLeast_m = 1e-6, kMost_m = 1e6;
    Eigen::AlignedBox3d box_m;
    for (const Eigen::Vector3d& p : mesh.position_m) box_m.extend(p);
    const double diagonal_m = box_m.diagonal().norm();
    if (diagonal_m < kLeast_m || diagonal_m > kMost_m)
        throw Error(
            fmt::format("{}: the mesh is {:.3g} m across, and {} to {} m is what a finger can touch: give the "
                        "right {}",
                        scene.file.string(), diagonal_m, kLeast_m, kMost_m,
                        scene.mesh.generate.empty() ? "mesh.scale (metres per unit)" : "mesh.side"));
}

/// A body that lies twice in one place has no surface that a finger could meet.
void require_unfolded(const Scene& scene, const Body& body) {
    const std::vector<std::int32_t> folded = find_folded(body.mesh.tet);
    if (folded.empty()) return;
    const auto first = static_cast<std::size_t>(folded.front());
    const std::vector<std::uint64_t>& number = body.mesh.tet_number;
    throw Error(
        fmt::format("{}: the mesh folds over itself at {} tetrahedra (element {} is the first): they are inverted by "
                    "their geometry, which turning their nodes cannot mend; mesh the body again",
                    (scene.mesh.file.empty() ? scene.file : scene.mesh.file).string(), folded.size(),
                    number.empty() ? first : number[first]));
}

void number_unknowns(const Flags& fixed, Body& body) {
    body.unknown.assign(fixed.size(), -1);
    for (std::size_t i = 0; i < fixed.size(); ++i)
        if (!fixed[i]) {
            body.unknown[i] = static_cast<std::int32_t>(body.free_node.size());
            body.free_node.push_back(static_cast<std::int32_t>(i));
        }
    for (std::int32_t node : body.surface.node)
        if (!body.is_fixed(node)) body.free_surface_node.push_back(node);
}

void find_touchable(const Scene& scene, Body& body) {
    Flags region(body.unknown.size(), 1);
    if (!scene.touch.empty()) region = mark(scene, scene.touch, "touch", body.mesh);
    for (const Patch& patch : body.surface.patch)
        if (std::all_of(patch.begin(), patch.end(), [&](auto i) { return region[static_cast<std::size_t>(i)] != 0; }))
            body.touch_patch.push_back(patch);
    for (const Patch& patch : body.touch_patch)
        for (std::int32_t node : patch)
            if (!body.is_fixed(node)) body.touch_node.push_back(node);
    std::sort(body.touch_node.begin(), body.touch_node.end());
    body.touch_node.erase(std::unique(body.touch_node.begin(), body.touch_node.end()), body.touch_node.end());
}

void require_touchable(const Scene& scene, const Body& body) {
    const std::string where =
        fmt::format("{}:{}: ", scene.file.string(), scene.touch.empty() ? 1 : scene.touch.front().line);
    if (body.touch_patch.empty())
        throw Error(where + "touch: the region is empty: no surface patch has all its nodes in it; make it larger");
    if (body.touch_node.empty())
        throw Error(where +
                    "touch: all nodes of its patches are held still, so that nothing would give way; "
                    "touch elsewhere or hold less");
}

}  // namespace

std::string describe(const Eigen::AlignedBox3d& box_m) {
    return fmt::format("[{:.6g}, {:.6g}, {:.6g}, {:.6g}, {:.6g}, {:.6g}] m", box_m.min().x(), box_m.min().y(),
                       box_m.min().z(), box_m.max().x(), box_m.max().y(), box_m.max().z());
}

TetMesh make_mesh(const MeshSource& source) {
    if (source.generate == "cube") return make_cube(source.nodes_per_side, source.side_m);
    const FillTarget fill{source.edge_length_m / source.scale_m, source.node_count};
    return read_mesh(source.file, ReadOptions{source.scale_m, source.linearize, fill});
}

Body make_body(const Scene& scene, TetMesh mesh) {
    require_size(scene, mesh);
    Body body;
    body.mesh = std::move(mesh);
    body.surface = find_surface(body.mesh.tet);
    require_unfolded(scene, body);
    number_unknowns(mark(scene, scene.fixed, "fixed", body.mesh), body);
    find_touchable(scene, body);
    require_touchable(scene, body);
    return body;
}

}  // namespace haptable
