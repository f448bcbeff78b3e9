// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/read_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/text.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/middles.hpp"
#include "host/mesh/quadratic_tet.hpp"
#include "host/mesh/raw_mesh.hpp"
#include "host/mesh/readers.hpp"
#include "host/mesh/soup.hpp"
#include "host/mesh/surface.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

std::string read_whole(const fs::path& file) {
    std::error_code ignored;
    if (fs::is_directory(file, ignored)) fail(file, "is a folder, not a mesh file");
    if (fs::is_other(file, ignored)) fail(file, "is a device or a pipe, not a mesh file");
    if (!fs::exists(file, ignored)) fail(file, "mesh file cannot be read: there is none; mend mesh.file in the scene");
    std::string text = read_text(file);
    if (text.empty()) fail(file, "the file is empty; give a mesh");
    if (text.starts_with("version https://git-lfs"))
        fail(file, "is a Git LFS pointer, not the mesh; fetch it with: git lfs pull");
    return text;
}

/// What the file holds, by its content; only where the content does not tell (numbers alone) by its name.
RawMesh read_raw(const fs::path& path, const std::vector<std::string>& vectors) {
    const std::string text = read_whole(path);
    const MeshFile file(path, text, vectors);
    std::vector<std::string> titles;
#define HAPTABLE_MESH_FORMAT(NAME, TITLE, ...)     \
    if (is_##NAME(file)) return read_##NAME(file); \
    titles.emplace_back(TITLE);
#include "host/base/mesh_formats.inc"
    fail(path,
         fmt::format("its content is no mesh that is known here ({}); convert it with Gmsh", fmt::join(titles, ", ")));
}

/// A triangle of a node that the file lacks bounds nothing.
void require_triangles(const fs::path& file, const RawMesh& raw) {
    if (!raw.tet.empty() || raw.triangle.empty()) return;
    std::vector<Tag> known = raw.node_tag;
    std::sort(known.begin(), known.end());
    for (std::size_t t = 0; t < raw.triangle.size(); ++t)
        for (Tag tag : raw.triangle[t])
            if (!std::binary_search(known.begin(), known.end(), tag))
                fail(file, fmt::format("triangle {} names node {}, which the file does not have", t + 1, tag));
}

/// The file's own nodes in the middle of edges are kept.
bool takes_middles(const RawMesh& raw, const ReadOptions& options) {
    return options.quadratic && !options.linearize && raw.second_order > 0;
}

/// "; the body is 136 m long ...", where its scale is to be doubted.
std::string doubt_size(const RawMesh& raw, const ReadOptions& options) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : raw.position) box.extend(p);
    if (box.isEmpty()) return "";
    const std::string doubt = doubt_scale(options.scale_m * box.sizes().maxCoeff(), options.scale_m);
    return doubt.empty() ? "" : "; " + doubt;
}

void require_tets(const fs::path& file, const RawMesh& raw, const ReadOptions& options) {
    for (const RawOthers& other : raw.other)
        fail(file, fmt::format("has {} elements of type {} (element {} is the first); only 4-node tetrahedra are "
                               "taken: mesh the body again with linear tetrahedra",
                               other.count, other.type, other.first));
    if (raw.tet.empty() && !raw.triangle.empty()) {
        Soup soup;
        to_soup(raw, soup);
        fail(file, fmt::format("has no tetrahedra but a surface: {}; to fill it give node_count = 2000 or edge_length "
                               "(metres) in [mesh]{}",
                               describe(soup), doubt_size(raw, options)));
    }
    if (raw.tet.empty())
        fail(file, fmt::format("has no tetrahedra ({} surface elements); give a volume mesh", raw.surface_elements));
    if (raw.second_order > 0 && !options.linearize && !options.quadratic)
        fail(file,
             fmt::format("has {} second-order tetrahedra (element {} is the first); set element = \"quadratic\" in "
                         "[mesh] to take them as they are, linearize = true to take their corners, or save it with "
                         "linear ones",
                         raw.second_order, raw.first_second_order));
    if (takes_middles(raw, options) && raw.second_order < raw.tet.size())
        fail(file, fmt::format("has {} linear tetrahedra beside {} second-order ones (element {} is the first of "
                               "these), which do not meet; set linearize = true in [mesh] to take the corners of all, "
                               "whose edges then get straight middles",
                               raw.tet.size() - raw.second_order, raw.second_order, raw.first_second_order));
    if (raw.tet.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / 4)
        fail(file, fmt::format("has {} tetrahedra, more than can be numbered; use a coarser mesh", raw.tet.size()));
}

template <typename T>
void sort_unique(std::vector<T>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Maps the node tags of the file, which may be sparse and huge, to mesh nodes: the rank among the used tags.
class NodeMap {
public:
    NodeMap(const RawMesh& raw, bool with_middles) {
        for (const auto& tet : raw.tet) tag_.insert(tag_.end(), tet.begin(), tet.end());
        if (with_middles)
            for (const auto& middle : raw.middle) tag_.insert(tag_.end(), middle.begin(), middle.end());
        sort_unique(tag_);
    }
    std::size_t size() const { return tag_.size(); }
    Tag tag(std::size_t node) const { return tag_[node]; }
    /// The mesh node, or -1 where no tetrahedron uses the tag.
    std::int32_t find(Tag tag) const {
        const auto it = std::lower_bound(tag_.begin(), tag_.end(), tag);
        return it != tag_.end() && *it == tag ? static_cast<std::int32_t>(it - tag_.begin()) : -1;
    }

private:
    std::vector<Tag> tag_;  // ascending
};

/// Every tag of a tetrahedron is a node's, no node's is given twice, and no tetrahedron names one twice.
void require_nodes(const fs::path& file, const RawMesh& raw, bool with_middles) {
    std::vector<Tag> known = raw.node_tag;
    std::sort(known.begin(), known.end());
    if (const auto twice = std::adjacent_find(known.begin(), known.end()); twice != known.end())
        fail(file, fmt::format("node number {} is given twice; give every node a number of its own", *twice));
    for (std::size_t t = 0; t < raw.tet.size(); ++t) {
        std::vector<Tag> node(raw.tet[t].begin(), raw.tet[t].end());
        if (with_middles) node.insert(node.end(), raw.middle[t].begin(), raw.middle[t].end());
        for (Tag tag : node)
            if (!std::binary_search(known.begin(), known.end(), tag))
                fail(file, fmt::format("element {} names node {}, which the file does not have; save the mesh again",
                                       raw.tet_tag[t], tag));
        std::sort(node.begin(), node.end());
        if (const auto twice = std::adjacent_find(node.begin(), node.end()); twice != node.end())
            fail(file, fmt::format("element {} names node {} twice; remove it or mesh the body again", raw.tet_tag[t],
                                   *twice));
    }
}

/// An edge has one node in its middle, whichever tetrahedron is asked, and that is no corner.
void require_middles(const fs::path& file, const RawMesh& raw) {
    struct Middle {
        std::array<Tag, 2> edge;
        Tag node;
        std::size_t tet;
    };
    std::vector<Middle> all;
    std::vector<Tag> corner;
    for (std::size_t t = 0; t < raw.tet.size(); ++t) {
        corner.insert(corner.end(), raw.tet[t].begin(), raw.tet[t].end());
        for (std::size_t e = 0; e < 6; ++e) {
            const auto [low, high] = std::minmax(raw.tet[t][kTetEdges[e][0]], raw.tet[t][kTetEdges[e][1]]);
            all.push_back({{low, high}, raw.middle[t][e], t});
        }
    }
    sort_unique(corner);
    const auto fail_at = [&](const Middle& one, const Middle& other, const std::string& what) {
        fail(file, fmt::format("elements {} and {}: {}; the second-order mesh does not fit together: save it again, or "
                               "set linearize = true in [mesh]",
                               raw.tet_tag[one.tet], raw.tet_tag[other.tet], what));
    };
    std::sort(all.begin(), all.end(), [](const Middle& a, const Middle& b) { return a.edge < b.edge; });
    for (std::size_t k = 0; k < all.size(); ++k) {
        if (std::binary_search(corner.begin(), corner.end(), all[k].node))
            fail(file, fmt::format("element {}: node {} in the middle of its edge {}-{} is a corner of a tetrahedron; "
                                   "the second-order mesh does not fit together: save it again, or set linearize = "
                                   "true in [mesh]",
                                   raw.tet_tag[all[k].tet], all[k].node, all[k].edge[0], all[k].edge[1]));
        if (k > 0 && all[k].edge == all[k - 1].edge && all[k].node != all[k - 1].node)
            fail_at(all[k - 1], all[k],
                    fmt::format("their common edge {}-{} has node {} in its middle for one and {} for the other",
                                all[k].edge[0], all[k].edge[1], all[k - 1].node, all[k].node));
    }
    std::sort(all.begin(), all.end(), [](const Middle& a, const Middle& b) { return a.node < b.node; });
    for (std::size_t k = 1; k < all.size(); ++k)
        if (all[k].node == all[k - 1].node && all[k].edge != all[k - 1].edge)
            fail_at(all[k - 1], all[k],
                    fmt::format("node {} is in the middle of two edges, {}-{} and {}-{}", all[k].node,
                                all[k - 1].edge[0], all[k - 1].edge[1], all[k].edge[0], all[k].edge[1]));
}

/// Twice the same tetrahedron would be twice as stiff.
void require_different(const fs::path& file, const RawMesh& raw) {
    std::vector<std::pair<std::array<Tag, 4>, std::size_t>> all;
    for (std::size_t t = 0; t < raw.tet.size(); ++t) {
        all.emplace_back(raw.tet[t], t);
        std::sort(all.back().first.begin(), all.back().first.end());
    }
    std::sort(all.begin(), all.end());
    for (std::size_t k = 1; k < all.size(); ++k)
        if (all[k].first == all[k - 1].first)
            fail(file, fmt::format(
                           "elements {} and {} are the same tetrahedron, which would double its stiffness; remove one",
                           raw.tet_tag[all[k - 1].second], raw.tet_tag[all[k].second]));
}

void place_nodes(const fs::path& file, const RawMesh& raw, double scale_m, const NodeMap& map, TetMesh& mesh) {
    mesh.position_m.resize(map.size());
    mesh.scan_distance_m.resize(raw.scan_distance.empty() ? 0 : map.size());
    for (std::size_t k = 0; k < raw.node_tag.size(); ++k) {
        const std::int32_t node = map.find(raw.node_tag[k]);
        if (node < 0) continue;
        if (!raw.position[k].allFinite() || !(scale_m * raw.position[k]).allFinite())
            fail(file, fmt::format("node {} has no finite position; mend its coordinates", raw.node_tag[k]));
        mesh.position_m[static_cast<std::size_t>(node)] = scale_m * raw.position[k];
        if (!raw.scan_distance.empty())
            mesh.scan_distance_m[static_cast<std::size_t>(node)] = scale_m * raw.scan_distance[k];
    }
    mesh.unused_nodes = raw.node_tag.size() - map.size();
    if (mesh.unused_nodes > 0)
        mesh.notes.push_back(fmt::format("{}: left out {} of {} nodes, which no tetrahedron uses", file.string(),
                                         mesh.unused_nodes, raw.node_tag.size()));
}

/// Far from the origin, the float32 coordinates of servo and finger would not tell its nodes apart: the body is moved
/// to the origin, before anything is computed from differences of its coordinates.
void move_to_origin(const fs::path& file, TetMesh& mesh) {
    constexpr double kFarthest = 1000.0;  // diagonals: 2^-24 of them is a 16,000th of the body
    Eigen::AlignedBox3d box_m;
    for (const Eigen::Vector3d& p : mesh.position_m) box_m.extend(p);
    if (!(box_m.center().norm() > kFarthest * box_m.diagonal().norm())) return;
    mesh.origin_m = box_m.center();
    for (Eigen::Vector3d& p : mesh.position_m) p -= mesh.origin_m;
    mesh.notes.push_back(
        fmt::format("{}: the body lies far from the origin: its centre ({:.9g}, {:.9g}, {:.9g}) m is the origin of "
                    "tables and finger "
                    "(the scene's boxes stay in the file's frame)",
                    file.string(), mesh.origin_m.x(), mesh.origin_m.y(), mesh.origin_m.z()));
}

/// The volume that rounding of the coordinates alone can give a flat tetrahedron, times six:
/// an error of eps |x| in one corner, times the area of the opposite face. reach: |x| in the file, at the least.
double rounding_volume(const std::vector<Eigen::Vector3d>& position_m, const Tet& tet, double reach) {
    double edge = 0.0;
    for (std::int32_t a : tet) {
        const Eigen::Vector3d& p = position_m[static_cast<std::size_t>(a)];
        reach = std::max(reach, p.cwiseAbs().maxCoeff());
        for (std::int32_t b : tet) edge = std::max(edge, (p - position_m[static_cast<std::size_t>(b)]).norm());
    }
    return 16.0 * std::numeric_limits<double>::epsilon() * reach * edge * edge;
}

/// Fills mesh.tet, positively oriented, and mesh.middle. reach: distance of the body from the file's origin.
void orient_tets(const fs::path& file, const RawMesh& raw, const NodeMap& map, double reach, bool with_middles,
                 TetMesh& mesh) {
    for (std::size_t t = 0; t < raw.tet.size(); ++t) {
        Tet tet{};
        MiddleNodes middle{};
        for (std::size_t c = 0; c < 4; ++c) tet[c] = map.find(raw.tet[t][c]);
        for (std::size_t e = 0; with_middles && e < 6; ++e) middle[e] = map.find(raw.middle[t][e]);
        const double volume = six_volumes(mesh.position_m, tet);
        if (!(std::abs(volume) > rounding_volume(mesh.position_m, tet, reach)))
            fail(file, fmt::format("element {} (nodes {}) has no volume; remove it or mesh the body again",
                                   raw.tet_tag[t], fmt::join(raw.tet[t], ", ")));
        if (volume < 0.0) {
            turn(tet, middle);
            ++mesh.turned;
        }
        mesh.tet.push_back(tet);
        if (with_middles) mesh.middle.push_back(middle);
        mesh.tet_number.push_back(raw.tet_tag[t]);
    }
    if (mesh.turned > 0)
        mesh.notes.push_back(fmt::format("{}: turned {} of {} tetrahedra, which stood the other way round",
                                         file.string(), mesh.turned, raw.tet.size()));
}

void map_groups(const RawMesh& raw, const NodeMap& map, TetMesh& mesh) {
    for (const auto& [name, from] : raw.group) {
        MeshGroup& group = mesh.group[name];
        group.tet.assign(from.tet.begin(), from.tet.end());
        for (Tag tag : from.node)
            if (const std::int32_t node = map.find(tag); node >= 0) group.node.push_back(node);
        for (std::int32_t t : group.tet)
            for_each_node(mesh, static_cast<std::size_t>(t), [&](std::int32_t node) { group.node.push_back(node); });
        for (const auto& corner : from.triangle) {
            const Patch patch{map.find(corner[0]), map.find(corner[1]), map.find(corner[2])};
            if (*std::min_element(patch.begin(), patch.end()) >= 0) group.triangle.push_back(patch);
        }
        sort_unique(group.node);
        sort_unique(group.tet);
    }
}

/// Names that were asked for: one vector a tetrahedron.
void take_vectors(const fs::path& file, const RawMesh& raw, const ReadOptions& options, TetMesh& mesh) {
    for (const std::string& name : options.vectors) {
        const auto found = raw.vectors.find(name);
        if (found == raw.vectors.end() || found->second.size() != mesh.tet.size())
            fail(file, fmt::format("has no vectors \"{}\" of its tetrahedra, which a material's directions are to "
                                   "follow; give a VTK file with cell data of that name, three components each",
                                   name));
        mesh.vectors[name] = found->second;
    }
}

/// Gives each middle of an edge, which was made, the mean distance of its ends.
void add_scan_distances(TetMesh& mesh) {
    if (mesh.scan_distance_m.empty()) return;
    mesh.scan_distance_m.resize(mesh.position_m.size());
    const auto of = [&](std::int32_t node) -> double& { return mesh.scan_distance_m[static_cast<std::size_t>(node)]; };
    for (std::size_t t = 0; t < mesh.tet.size(); ++t)
        for (std::size_t e = 0; e < 6; ++e)
            of(mesh.middle[t][e]) = 0.5 * (of(mesh.tet[t][kTetEdges[e][0]]) + of(mesh.tet[t][kTetEdges[e][1]]));
}

TetMesh make_tet_mesh(const fs::path& file, const RawMesh& raw, const ReadOptions& options) {
    require_tets(file, raw, options);
    const bool with_middles = takes_middles(raw, options);
    require_nodes(file, raw, with_middles);
    if (with_middles) require_middles(file, raw);
    require_different(file, raw);
    const NodeMap map(raw, with_middles);
    if (map.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / 3)
        fail(file, fmt::format("has {} nodes, more than can be numbered; use a coarser mesh", map.size()));
    TetMesh mesh;
    for (const std::string& note : raw.notes) mesh.notes.push_back(file.string() + ": " + note);
    place_nodes(file, raw, options.scale_m, map, mesh);
    const double far_m = mesh.position_m.empty() ? 0.0 : mesh.position_m[0].norm();
    move_to_origin(file, mesh);
    orient_tets(file, raw, map, far_m, with_middles, mesh);
    if (raw.second_order > 0 && !with_middles)
        mesh.notes.push_back(
            fmt::format("{}: took {} second-order tetrahedra by their corners", file.string(), raw.second_order));
    map_groups(raw, map, mesh);
    take_vectors(file, raw, options, mesh);
    if (options.quadratic && !with_middles) {
        add_middles(mesh);
        add_scan_distances(mesh);
    }
    return mesh;
}

}  // namespace

TetMesh read_mesh(const fs::path& file, const ReadOptions& options) {
    const RawMesh raw = read_raw(file, options.vectors);
    require_triangles(file, raw);
    if (!options.fill.given()) return make_tet_mesh(file, raw, options);
    if (!raw.tet.empty() || !raw.other.empty())
        fail(file, "is a volume mesh, which is not filled; remove edge_length and node_count from [mesh]");
    if (raw.triangle.empty()) fail(file, "has no triangles to fill; give a closed surface");
    RawMesh filled;
    try {
        filled = fill_surface(file, raw, options.fill, options.watch);
    } catch (const Error& error) {  // which may be due to the size that a wrong scale gives
        throw Error(error.what() + doubt_size(raw, options));
    }
    return make_tet_mesh(file, filled, options);
}

Soup read_triangles(const fs::path& file, double scale_m) {
    const RawMesh raw = read_raw(file, {});
    Soup soup;
    if (!raw.tet.empty() || !raw.other.empty()) {
        const TetMesh mesh = make_tet_mesh(file, raw, ReadOptions{scale_m, false, {}, {}});
        for (const Eigen::Vector3d& p : mesh.position_m) soup.point.push_back(mesh.origin_m + p);
        for (const Patch& patch : find_surface(mesh.tet).patch)
            soup.triangle.push_back({static_cast<std::size_t>(patch[0]), static_cast<std::size_t>(patch[1]),
                                     static_cast<std::size_t>(patch[2])});
        return soup;
    }
    require_triangles(file, raw);
    to_soup(raw, soup);
    if (soup.triangle.empty()) fail(file, "has no triangles; give a surface");
    for (Eigen::Vector3d& p : soup.point) p *= scale_m;
    return soup;
}

std::vector<fs::path> mesh_files(const fs::path& file) {
    const std::string kind = lower(file.extension().string());
    if (kind != ".node" && kind != ".ele") return {file};
    return {fs::path(file).replace_extension(".node"), fs::path(file).replace_extension(".ele")};
}

}  // namespace haptable
