// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "host/base/error.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/middles.hpp"
#include "host/mesh/quadratic_tet.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/mesh/shells.hpp"

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
    for (const Eigen::Vector3d& p : mesh.position_m) box_m.extend(mesh.origin_m + p);
    return describe(box_m);
}

void mark_box(const Scene& scene, const Selection& selection, const char* key, const TetMesh& mesh, Flags& flags) {
    bool any = false;
    for (std::size_t i = 0; i < flags.size(); ++i)
        if (inside(*selection.box_m, mesh.origin_m + mesh.position_m[i])) flags[i] = any = true;
    if (!any)
        fail(scene, selection,
             fmt::format("{}.box: no node lies in it; the mesh fills the box {}: move the box or mend the mesh's "
                         "scale",
                         key, extent(mesh)));
}

/// Nodes of the layer over the outermost one, which it has at the least; rounding of a plane's nodes is none.
void mark_below(const Below& below, const TetMesh& mesh, Flags& flags) {
    constexpr double kRoundingOfHeight = 1e-9;  // of the body's height
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    const auto height = [&](std::size_t i) { return (below.is_turned ? -1.0 : 1.0) * mesh.position_m[i][below.axis]; };
    for (std::size_t i = 0; i < flags.size(); ++i) {
        lowest = std::min(lowest, height(i));
        highest = std::max(highest, height(i));
    }
    for (std::size_t i = 0; i < flags.size(); ++i)
        if (height(i) <= lowest + below.depth_m + kRoundingOfHeight * (highest - lowest)) flags[i] = 1;
}

/// The group that a selection names. Throws Error with all names where it has none of `what`.
const MeshGroup& group_of(const Scene& scene, const Selection& selection, const char* key, const TetMesh& mesh,
                          const char* what, bool (*has)(const MeshGroup&)) {
    const auto group = mesh.group.find(selection.group);
    if (group != mesh.group.end() && has(group->second)) return group->second;
    std::vector<std::string> names;
    for (const auto& [name, unused] : mesh.group) names.push_back(name);
    fail(scene, selection,
         fmt::format("{}.group: the mesh has no {} in a group \"{}\"; its groups: {}", key, what, selection.group,
                     names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

void mark_group(const Scene& scene, const Selection& selection, const char* key, const TetMesh& mesh, Flags& flags) {
    const MeshGroup& group =
        group_of(scene, selection, key, mesh, "nodes", [](const MeshGroup& g) { return !g.node.empty(); });
    for (std::int32_t node : group.node) flags[static_cast<std::size_t>(node)] = 1;
}

/// The nodes that any of the selections holds.
Flags mark(const Scene& scene, const std::vector<Selection>& selections, const char* key, const TetMesh& mesh) {
    Flags flags(mesh.position_m.size(), 0);
    for (const Selection& selection : selections)
        if (selection.below)
            mark_below(*selection.below, mesh, flags);
        else if (selection.box_m)
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

/// Where the middles of its edges lie so far off that a tetrahedron folds, no turning mends it.
void require_jacobians(const Scene& scene, const TetMesh& mesh) {
    for (std::size_t t = 0; t < mesh.middle.size(); ++t) {
        const DetRange det = det_range(ten_nodes(mesh.position_m, mesh.tet[t], mesh.middle[t]));
        constexpr double kLeast = 1e-6;  // of the element's own: what a rounding of its nodes may turn round
        if (det.least_m3 > kLeast * det.greatest_m3) continue;
        throw Error(fmt::format(
            "{}: second-order element {} folds over itself: its Jacobian is {:.3g} m^3 at a point of integration and "
            "{:.3g} m^3 at another; move the nodes in the middle of its edges, or set linearize = true in [mesh] to "
            "make them straight",
            (scene.mesh.file.empty() ? scene.file : scene.mesh.file).string(),
            mesh.tet_number.empty() ? t : mesh.tet_number[t], det.least_m3, det.greatest_m3));
    }
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

Eigen::Vector3d centre_of(const TetMesh& mesh, std::size_t t) {
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    for (std::int32_t i : mesh.tet[t]) centre_m += 0.25 * mesh.position_m[static_cast<std::size_t>(i)];
    return centre_m;
}

/// Tetrahedra of a region: of its group, or with their centre in its box.
std::vector<std::int32_t> tets_of(const Scene& scene, const Selection& where, const TetMesh& mesh) {
    if (!where.box_m)
        return group_of(scene, where, "region", mesh, "tetrahedra", [](const MeshGroup& g) { return !g.tet.empty(); })
            .tet;
    std::vector<std::int32_t> tets;
    for (std::size_t t = 0; t < mesh.tet.size(); ++t) {
        if (inside(*where.box_m, mesh.origin_m + centre_of(mesh, t))) tets.push_back(static_cast<std::int32_t>(t));
    }
    if (tets.empty())
        fail(scene, where,
             fmt::format("region.box: no tetrahedron has its centre in it; the mesh fills the box {}", extent(mesh)));
    return tets;
}

void mark_regions(const Scene& scene, Body& body) {
    body.region.assign(body.mesh.tet.size(), -1);
    for (std::size_t r = 0; r < scene.regions.size(); ++r)
        for (std::int32_t t : tets_of(scene, scene.regions[r].where, body.mesh)) {
            std::int32_t& region = body.region[static_cast<std::size_t>(t)];
            if (region >= 0)
                fail(scene, scene.regions[r].where,
                     fmt::format("region: tetrahedron {} (from 0) is in the region of line {} too; a tetrahedron has "
                                 "one material",
                                 t, scene.regions[static_cast<std::size_t>(region)].where.line));
            region = static_cast<std::int32_t>(r);
        }
}

Eigen::Vector3d vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

/// Directions 1 and about 2 of one tetrahedron; 2 is 0 where it does not matter. Around an axis they are 0 on it.
std::array<Eigen::Vector3d, 2> directions_of(const MaterialAxes& axes, const TetMesh& mesh, std::size_t t) {
    if (axes.around) {
        const Eigen::Vector3d along = vector_of((*axes.around)[1]).normalized();
        const Eigen::Vector3d out = mesh.origin_m + centre_of(mesh, t) - vector_of((*axes.around)[0]);
        return {along.cross(out), along};
    }
    const auto pick = [&](std::size_t k) -> Eigen::Vector3d {
        return axes.field[k].empty() ? vector_of(axes.direction[k]) : mesh.vectors.at(axes.field[k])[t];
    };
    return {pick(0), pick(1)};
}

/// Right-handed, its first column along 1. Without a second direction any does.
Eigen::Matrix3d frame_of(const std::array<Eigen::Vector3d, 2>& direction) {
    const Eigen::Vector3d one = direction[0].normalized();
    const Eigen::Vector3d about = direction[1].isZero(0.0) ? one.unitOrthogonal() : direction[1].normalized();
    Eigen::Matrix3d frame;
    frame << one, (about - about.dot(one) * one).normalized(), one.cross(about).normalized();
    return frame;
}

void find_axes(const Scene& scene, Body& body) {
    constexpr double kLeastSine = 1e-6;  // between two directions
    for (std::size_t t = 0; t < body.mesh.tet.size(); ++t) {
        const Material& material = scene.material_of(body.region[t]);
        if (!material.orthotropic) continue;
        const auto direction = directions_of(material.orthotropic->axes, body.mesh, t);
        const double sine = direction[0].normalized().cross(direction[1].normalized()).norm();
        if (!(direction[0].norm() > 0.0) || !(direction[1].isZero(0.0) || sine > kLeastSine))
            throw Error(fmt::format(
                "{}:{}: the material has no directions in tetrahedron {} (from 0): they are 0 or parallel there; "
                "mend the field, or lay the axis where no element's centre is",
                scene.file.string(), material.orthotropic->axes.line, t));
        if (body.axes.empty()) body.axes.assign(body.mesh.tet.size(), Eigen::Matrix3d::Identity());
        body.axes[t] = frame_of(direction);
    }
}

/// The corners of the element's face that a patch is, or is a quarter of; ascending.
Patch corners_of_face(const Surface& surface, std::size_t p) {
    Patch corners = surface.patch[p];
    if (!surface.face.empty()) std::copy_n(surface.face[p / 4].begin(), 3, corners.begin());
    std::sort(corners.begin(), corners.end());
    return corners;
}

/// Faces of the surface: patches, or what four of them are quarters of.
std::vector<LayeredFace> faces_of(const Surface& surface) {
    std::vector<LayeredFace> faces;
    for (const QuadraticFace& face : surface.face) faces.push_back({face, 6, {}});
    if (!surface.face.empty()) return faces;
    for (const Patch& patch : surface.patch) {
        LayeredFace& face = faces.emplace_back();
        std::copy(patch.begin(), patch.end(), face.node.begin());
    }
    return faces;
}

Patch sorted_corners(const std::int32_t* corner) {
    Patch corners{corner[0], corner[1], corner[2]};
    std::sort(corners.begin(), corners.end());
    return corners;
}

/// Adds a layer to the faces that are triangles of its group, or whose nodes it all holds.
void add_layer(const Scene& scene, const Body& body, const Selection& where, const char* key, const Layer& layer,
               std::vector<LayeredFace>& faces) {
    std::set<Patch> triangles;
    if (const auto group = body.mesh.group.find(where.group); !where.box_m && group != body.mesh.group.end())
        for (const Patch& triangle : group->second.triangle) triangles.insert(sorted_corners(triangle.data()));
    const Flags held = triangles.empty() ? mark(scene, {where}, key, body.mesh) : Flags();
    bool any = false;
    for (LayeredFace& face : faces) {
        const auto nodes = nodes_of(face);
        const auto is_held = [&](std::int32_t i) { return held[static_cast<std::size_t>(i)] != 0; };
        if (triangles.empty() ? !std::all_of(nodes.begin(), nodes.end(), is_held)
                              : !triangles.contains(sorted_corners(face.node.data())))
            continue;
        face.layer += layer;
        any = true;
    }
    if (!any)
        fail(scene, where,
             fmt::format("{}: no face of the surface has all its nodes in it; make the box or group larger", key));
}

void find_layers(const Scene& scene, Body& body) {
    if (scene.membranes.empty() && scene.beds.empty()) return;
    std::vector<LayeredFace> faces = faces_of(body.surface);
    for (const Membrane& m : scene.membranes)
        add_layer(scene, body, m.where, "membrane", Layer::membrane(m.thickness_m, m.young_pa, m.poisson), faces);
    for (const Bed& b : scene.beds)
        add_layer(scene, body, b.where, "bed", Layer::bed(b.normal_n_per_m3, b.tangential_n_per_m3), faces);
    for (const LayeredFace& face : faces)
        if (face.layer.has_membrane() || face.layer.has_bed()) body.layered.push_back(face);
}

/// Marks the patches of one [[touch]]: those that are triangles of its group, or whose nodes it all holds.
void mark_patches(const Body& body, const Shells& shells, const Flags& node, const MeshGroup* group, bool cavities,
                  Flags& touch) {
    std::set<Patch> triangles;
    if (group != nullptr)
        for (Patch triangle : group->triangle) {
            std::sort(triangle.begin(), triangle.end());
            triangles.insert(triangle);
        }
    for (std::size_t p = 0; p < touch.size(); ++p) {
        if (!cavities && shells.is_cavity(shells.of_patch[p])) continue;
        const Patch& patch = body.surface.patch[p];
        const auto marked = [&](std::int32_t i) { return node[static_cast<std::size_t>(i)] != 0; };
        if (triangles.empty() ? std::all_of(patch.begin(), patch.end(), marked)
                              : triangles.contains(corners_of_face(body.surface, p)))
            touch[p] = 1;
    }
}

/// A patch belongs to the boxes and groups of nodes together, so that boxes side by side leave no gap; to a group of
/// triangles it belongs as one of them.
Flags touchable_patches(const Scene& scene, const Body& body) {
    const Shells shells = find_shells(body.mesh, body.surface, edges_of(body.surface.patch));
    Flags touch(body.surface.patch.size(), 0);
    if (scene.touch.empty()) mark_patches(body, shells, Flags(body.unknown.size(), 1), nullptr, false, touch);
    for (bool cavities : {false, true}) {
        std::vector<Selection> by_node;
        for (const Selection& selection : scene.touch) {
            if (selection.cavities != cavities) continue;
            const auto group = body.mesh.group.find(selection.group);
            if (selection.box_m || group == body.mesh.group.end() || group->second.triangle.empty())
                by_node.push_back(selection);
            else
                mark_patches(body, shells, {}, &group->second, cavities, touch);
        }
        if (!by_node.empty())
            mark_patches(body, shells, mark(scene, by_node, "touch", body.mesh), nullptr, cavities, touch);
    }
    return touch;
}

void find_touchable(const Scene& scene, Body& body) {
    const Flags touch = touchable_patches(scene, body);
    for (std::size_t p = 0; p < touch.size(); ++p) {
        if (!touch[p]) continue;
        body.touch_patch.push_back(body.surface.patch[p]);
        if (body.surface.face.empty()) continue;
        const std::size_t face = p / 4;
        const bool is_whole = std::all_of(&touch[4 * face], &touch[4 * face] + 4, [](char t) { return t != 0; });
        body.touch_quarter.push_back({body.surface.face[face], static_cast<int>(p % 4), is_whole});
    }
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
                    "touch: all nodes of its patches are fixed, so that nothing would give way; "
                    "touch elsewhere or fix less");
}

}  // namespace

std::string describe(const Eigen::AlignedBox3d& box_m) {
    return fmt::format("[{:.6g}, {:.6g}, {:.6g}, {:.6g}, {:.6g}, {:.6g}] m", box_m.min().x(), box_m.min().y(),
                       box_m.min().z(), box_m.max().x(), box_m.max().y(), box_m.max().z());
}

TetMesh make_mesh(const MeshSource& source, const WatchFill& watch) {
    const bool quadratic = source.element == Element::kQuadratic;
    const FillTarget fill{source.edge_length_m / source.scale_m, source.node_count, source.wrap};
    if (source.generate != "cube")
        return read_mesh(source.file,
                         ReadOptions{source.scale_m, source.linearize, fill, watch, quadratic, source.directions});
    TetMesh mesh = make_cube(source.nodes_per_side, source.side_m);
    if (quadratic) add_middles(mesh);
    return mesh;
}

std::vector<std::string> holding_warnings(const Scene& scene, const Body& body) {
    constexpr double kMuch = 0.3;
    constexpr std::size_t kCoarse = 64;  // a grid of three nodes a side has a third of them on one side
    const std::size_t nodes = body.mesh.position_m.size(), held = body.fixed_count();
    if (nodes < kCoarse || static_cast<double>(held) < kMuch * static_cast<double>(nodes)) return {};
    return {fmt::format(
        "{}:{}: fixed: holds {} of {} nodes ({:.0f} %), and nothing gives way there; the body fills the box {}: hold "
        "less, as by [[fixed]] below = 0.002, metres above its lowest node",
        scene.file.string(), scene.fixed.empty() ? 1 : scene.fixed.front().line, held, nodes,
        100.0 * static_cast<double>(held) / static_cast<double>(nodes), extent(body.mesh))};
}

Body make_body(const Scene& scene, TetMesh mesh) {
    require_size(scene, mesh);
    Body body;
    body.mesh = std::move(mesh);
    body.surface = find_surface(body.mesh);
    require_unfolded(scene, body);
    require_jacobians(scene, body.mesh);
    mark_regions(scene, body);
    find_axes(scene, body);
    find_layers(scene, body);
    number_unknowns(mark(scene, scene.fixed, "fixed", body.mesh), body);
    find_touchable(scene, body);
    require_touchable(scene, body);
    return body;
}

}  // namespace haptable
