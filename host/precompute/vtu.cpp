// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/vtu.hpp"

#include <fmt/format.h>

#include "host/base/index.hpp"
#include "host/base/vtu_text.hpp"

namespace haptable {

namespace {

using Flags = std::vector<std::uint8_t>;  // 0 or 1

Flags flags_of(const std::vector<std::int32_t>& nodes, std::size_t node_count) {
    Flags flags(node_count, 0);
    for (std::int32_t node : nodes) flags[at(node)] = 1;
    return flags;
}

/// Nodes of faces whose layer is such a one.
Flags flags_where(const Body& body, bool (Layer::*is)() const) {
    Flags flags(body.mesh.position_m.size(), 0);
    for (const LayeredFace& face : body.layered)
        for (std::int32_t node : nodes_of(face))
            if ((face.layer.*is)()) flags[at(node)] = 1;
    return flags;
}

void write_points(const Body& body, std::span<const Eigen::Vector3d> sag_m, VtuText& out) {
    const std::size_t node_count = body.mesh.position_m.size();
    Flags fixed(node_count, 1);
    for (std::int32_t node : body.free_node) fixed[at(node)] = 0;
    out.section("PointData");
    out.array("UInt8", "fixed", 1, fixed);
    out.array("UInt8", "surface", 1, flags_of(body.surface.node, node_count));
    out.array("UInt8", "touchable", 1, flags_of(body.touch_node, node_count));
    if (!body.layered.empty()) {
        out.array("UInt8", "membrane", 1, flags_where(body, &Layer::has_membrane));
        out.array("UInt8", "bed", 1, flags_where(body, &Layer::has_bed));
    }
    if (!sag_m.empty()) out.array("Float64", "sag", 3, sag_m);
    out.section("Points");
    out.array("Float64", "Points", 3, body.mesh.position_m);
}

/// In VTK's order, which is ours.
std::vector<std::array<std::int32_t, 10>> ten_nodes_of(const TetMesh& mesh) {
    std::vector<std::array<std::int32_t, 10>> nodes(mesh.tet.size());
    for (std::size_t t = 0; t < nodes.size(); ++t)
        for_each_node(mesh, t, [next = nodes[t].begin()](std::int32_t node) mutable { *next++ = node; });
    return nodes;
}

void write_cells(const Scene& scene, const Body& body, VtuText& out) {
    const std::size_t tets = body.mesh.tet.size(), patches = body.touch_patch.size();
    const bool quadratic = !body.mesh.middle.empty();
    const std::size_t each = quadratic ? 10 : 4;
    Flags is_patch(tets, 0), type(tets, quadratic ? kVtkQuadraticTetra : kVtkTetra);
    is_patch.resize(tets + patches, 1);
    type.resize(tets + patches, kVtkTriangle);
    std::vector<std::size_t> offset;
    for (std::size_t t = 1; t <= tets; ++t) offset.push_back(each * t);
    for (std::size_t p = 1; p <= patches; ++p) offset.push_back(each * tets + 3 * p);
    out.section("CellData");
    out.array("UInt8", "touchable_patch", 1, is_patch);
    if (!scene.regions.empty()) {
        std::vector<std::int32_t> region = body.region;
        region.resize(tets + patches, -1);
        out.array("Int32", "region", 1, region);
    }
    for (Eigen::Index k = 0; k < 3 && !body.axes.empty(); ++k) {  // none at a patch, nor where it is isotropic
        std::vector<Eigen::Vector3d> axis(tets + patches, Eigen::Vector3d::Zero());
        for (std::size_t t = 0; t < tets; ++t)
            if (scene.material_of(body.region[t]).orthotropic) axis[t] = body.axes[t].col(k);
        out.array("Float64", fmt::format("material_axis_{}", k + 1).c_str(), 3, axis);
    }
    out.section("Cells");
    if (quadratic)
        out.array("Int32", "connectivity", 1, ten_nodes_of(body.mesh), body.touch_patch);
    else
        out.array("Int32", "connectivity", 1, body.mesh.tet, body.touch_patch);
    out.array("Int64", "offsets", 1, offset);
    out.array("UInt8", "types", 1, type);
}

}  // namespace

std::string to_vtu(const Scene& scene, const Body& body, std::span<const Eigen::Vector3d> sag_m) {
    VtuText out(body.mesh.position_m.size(), body.mesh.tet.size() + body.touch_patch.size());
    write_points(body, sag_m, out);
    write_cells(scene, body, out);
    return out.finish();
}

}  // namespace haptable
