// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/read_mesh.hpp"

#include <fmt/format.h>
#include <gmsh.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include "host/base/error.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Tag = std::size_t;  // a node's or element's number in the file: from 1, with gaps

constexpr int kTriangle = 2;     // Gmsh's number of the 3-node triangle
constexpr int kTetrahedron = 4;  // and of the 4-node tetrahedron

[[noreturn]] void fail(const fs::path& file, const std::string& what) { throw Error(file.string() + ": " + what); }

/// Gmsh's VTK reader makes room for as many points as the file promises before it reads one: a damaged count would
/// take all memory.
void check_vtk_points(const fs::path& file, std::string_view head) {
    constexpr std::string_view kPoints = "\nPOINTS ";
    constexpr std::size_t kLeastBytes = 6;  // of a point: "0 0 0" and a separator
    const std::size_t at = head.find(kPoints);
    if (at == std::string_view::npos) return;
    const std::string_view count = head.substr(at + kPoints.size());
    std::size_t points = 0;
    const auto [end, failed] = std::from_chars(count.data(), count.data() + count.size(), points);
    if (failed != std::errc() || points > fs::file_size(file) / kLeastBytes)
        fail(file, fmt::format("promises {} points, more than its {} bytes can hold; save the mesh again",
                               count.substr(0, count.find_first_of(" \n")), fs::file_size(file)));
}

/// Gmsh takes what it does not know for a script of its own and runs it: only what begins like a mesh may come near.
void check_beginning(const fs::path& file) {
    std::error_code ignored;
    if (fs::is_directory(file, ignored)) fail(file, "is a folder, not a mesh file");
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    if (!in) fail(file, fmt::format("mesh file cannot be read: {}", std::strerror(errno != 0 ? errno : EIO)));
    std::string head(1024, '\0');
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(in.gcount()));
    const fs::path kind = file.extension();
    if (kind != ".msh" && kind != ".vtk")
        fail(file, "this version reads .msh and .vtk; convert it, for example: gmsh -save -o mesh.msh FILE");
    const bool msh = head.starts_with("$MeshFormat") || head.starts_with("$NOD") || head.starts_with("$Comments");
    if (kind == ".msh" && !msh) fail(file, "does not begin like a Gmsh mesh ($MeshFormat); save it again from Gmsh");
    if (kind == ".vtk" && !head.starts_with("# vtk"))
        fail(file, "does not begin like a legacy VTK file (# vtk DataFile); save it as legacy .vtk");
    if (kind == ".vtk") check_vtk_points(file, head);
}

/// The Gmsh library from initialize to finalize, with its terminal output off.
class GmshSession {
public:
    explicit GmshSession(const fs::path& file) {
        gmsh::initialize(0, nullptr, false);
        gmsh::option::setNumber("General.Terminal", 0);
        gmsh::logger::start();
        try {
            gmsh::open(file.string());
        } catch (...) {  // the library throws texts, numbers and exceptions; its log has the reason
            const std::string reason = last_error();
            end();
            fail(file, fmt::format("Gmsh cannot read it: {}; save the mesh again", reason));
        }
    }
    ~GmshSession() { end(); }
    GmshSession(const GmshSession&) = delete;
    GmshSession& operator=(const GmshSession&) = delete;

    /// What Gmsh warned of while reading.
    std::vector<std::string> warnings() const { return log("Warning: "); }

private:
    /// The logger outlives finalize(): left on, it would carry this file's lines into the next session.
    static void end() {
        gmsh::logger::stop();
        gmsh::finalize();
    }
    static std::string last_error() {
        const std::vector<std::string> errors = log("Error: ");
        return errors.empty() ? "it is damaged, or larger than the memory" : errors.back();
    }
    /// The log's lines of one level, without its name.
    static std::vector<std::string> log(std::string_view level) {
        std::vector<std::string> all, lines;
        gmsh::logger::get(all);
        for (const std::string& line : all)
            if (line.starts_with(level)) lines.push_back(line.substr(level.size()));
        return lines;
    }
};

/// Gmsh's warnings become notes; that it left out a node that another one shares its number with is no small thing.
void note_warnings(const fs::path& file, const GmshSession& session, TetMesh& mesh) {
    constexpr std::string_view kTwice = "Skipping duplicate node ";
    for (const std::string& warning : session.warnings()) {
        if (warning.starts_with(kTwice))
            fail(file, fmt::format("has node {} twice; give every node a number of its own, below 2147483648",
                                   warning.substr(kTwice.size())));
        mesh.notes.push_back(fmt::format("{}: Gmsh: {}", file.string(), warning));
    }
}

/// The file's tetrahedra by node tags; an error where it has other elements of three dimensions, or none.
struct RawTets {
    std::vector<Tag> tag;   // [T]
    std::vector<Tag> node;  // [4 T]
};

RawTets read_tets(const fs::path& file) {
    std::vector<int> types;
    std::vector<std::vector<Tag>> tags;
    std::vector<std::vector<Tag>> nodes;
    gmsh::model::mesh::getElements(types, tags, nodes);
    RawTets tets;
    std::size_t triangles = 0;
    for (std::size_t k = 0; k < types.size(); ++k) {
        std::string name;
        int dimension = 0, order = 0, node_count = 0, primary = 0;
        std::vector<double> local;
        gmsh::model::mesh::getElementProperties(types[k], name, dimension, order, node_count, local, primary);
        if (types[k] == kTetrahedron) {
            tets.tag.insert(tets.tag.end(), tags[k].begin(), tags[k].end());
            tets.node.insert(tets.node.end(), nodes[k].begin(), nodes[k].end());
        } else if (dimension == 3) {
            fail(file, fmt::format("has {} elements of type {} (element {} is the first); only 4-node tetrahedra are "
                                   "taken: mesh the body again with linear tetrahedra",
                                   tags[k].size(), name, tags[k].front()));
        } else if (dimension == 2) {
            triangles += tags[k].size();
        }
    }
    if (tets.tag.empty())
        fail(file, fmt::format("has no tetrahedra ({} surface elements); give a volume mesh, for example: gmsh -3 FILE",
                               triangles));
    return tets;
}

template <typename T>
void sort_unique(std::vector<T>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Maps the node tags of the file, which may be sparse and huge, to mesh nodes: the rank among the used tags.
class NodeMap {
public:
    explicit NodeMap(std::vector<Tag> used) : tag_(std::move(used)) { sort_unique(tag_); }
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

void read_positions(const fs::path& file, double scale_m, const NodeMap& map, TetMesh& mesh) {
    std::vector<Tag> tags;
    std::vector<double> coordinate, parameter;
    gmsh::model::mesh::getNodes(tags, coordinate, parameter);
    mesh.position_m.assign(map.size(), Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (std::size_t k = 0; k < tags.size(); ++k) {
        const std::int32_t node = map.find(tags[k]);
        if (node < 0) continue;
        const Eigen::Vector3d position_m = scale_m * Eigen::Vector3d::Map(&coordinate[3 * k]);
        mesh.position_m[static_cast<std::size_t>(node)] = position_m;
    }
    for (std::size_t i = 0; i < map.size(); ++i)
        if (!mesh.position_m[i].allFinite())
            fail(file, fmt::format("node {} has no finite position; mend its coordinates", map.tag(i)));
    if (tags.size() > map.size())
        mesh.notes.push_back(fmt::format("{}: left out {} of {} nodes, which no tetrahedron uses", file.string(),
                                         tags.size() - map.size(), tags.size()));
}

/// The volume that rounding of the coordinates alone can give a flat tetrahedron, times six:
/// an error of eps |x| in one corner, times the area of the opposite face.
double rounding_volume(const std::vector<Eigen::Vector3d>& position_m, const Tet& tet) {
    double reach = 0.0, edge = 0.0;
    for (std::int32_t a : tet) {
        const Eigen::Vector3d& p = position_m[static_cast<std::size_t>(a)];
        reach = std::max(reach, p.cwiseAbs().maxCoeff());
        for (std::int32_t b : tet) edge = std::max(edge, (p - position_m[static_cast<std::size_t>(b)]).norm());
    }
    return 16.0 * std::numeric_limits<double>::epsilon() * reach * edge * edge;
}

/// Fills mesh.tet, positively oriented.
void orient_tets(const fs::path& file, const RawTets& raw, const NodeMap& map, TetMesh& mesh) {
    std::size_t turned = 0;
    for (std::size_t t = 0; t < raw.tag.size(); ++t) {
        Tet tet{};
        for (std::size_t c = 0; c < 4; ++c) tet[c] = map.find(raw.node[4 * t + c]);
        const double volume = six_volumes(mesh.position_m, tet);
        if (!(std::abs(volume) > rounding_volume(mesh.position_m, tet)))
            fail(file, fmt::format("element {} (nodes {}) has no volume; remove it or mesh the body again", raw.tag[t],
                                   fmt::join(&raw.node[4 * t], &raw.node[4 * t] + 4, ", ")));
        if (volume < 0.0) {
            std::swap(tet[2], tet[3]);
            ++turned;
        }
        mesh.tet.push_back(tet);
    }
    if (turned > 0)
        mesh.notes.push_back(fmt::format("{}: turned {} of {} tetrahedra, which stood the other way round",
                                         file.string(), turned, raw.tag.size()));
}

/// Element tag to tetrahedron, both of the file, ascending by tag.
using TetIndex = std::vector<std::pair<Tag, std::int32_t>>;

TetIndex index_tets(const RawTets& raw) {
    TetIndex index;
    for (Tag tag : raw.tag) index.emplace_back(tag, static_cast<std::int32_t>(index.size()));
    std::sort(index.begin(), index.end());
    return index;
}

/// Adds the elements of one entity to a group.
void add_entity(int dimension, int entity, const NodeMap& map, const TetIndex& index, MeshGroup& group) {
    std::vector<int> types;
    std::vector<std::vector<Tag>> tags, nodes;
    gmsh::model::mesh::getElements(types, tags, nodes, dimension, entity);
    for (std::size_t k = 0; k < types.size(); ++k) {
        for (Tag tag : nodes[k])
            if (const std::int32_t node = map.find(tag); node >= 0) group.node.push_back(node);
        if (types[k] == kTriangle)
            for (std::size_t c = 0; c + 2 < nodes[k].size(); c += 3) {
                const Patch patch{map.find(nodes[k][c]), map.find(nodes[k][c + 1]), map.find(nodes[k][c + 2])};
                if (*std::min_element(patch.begin(), patch.end()) >= 0) group.triangle.push_back(patch);
            }
        if (types[k] == kTetrahedron)
            for (Tag tag : tags[k])
                group.tet.push_back(std::lower_bound(index.begin(), index.end(), std::pair(tag, 0))->second);
    }
}

void read_groups(const NodeMap& map, const RawTets& raw, TetMesh& mesh) {
    const TetIndex index = index_tets(raw);
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups);
    for (const auto& [dimension, tag] : groups) {
        std::string name;
        gmsh::model::getPhysicalName(dimension, tag, name);
        if (name.empty()) continue;  // a scene names groups; a bare number it cannot name
        std::vector<int> entities;
        gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, entities);
        for (int entity : entities) add_entity(dimension, entity, map, index, mesh.group[name]);
    }
    for (auto& [name, group] : mesh.group) {
        sort_unique(group.node);
        sort_unique(group.tet);
    }
}

}  // namespace

TetMesh read_mesh(const fs::path& file, double scale_m) {
    check_beginning(file);
    const GmshSession session(file);
    const RawTets raw = read_tets(file);
    const NodeMap map(raw.node);
    if (map.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) / 3)
        fail(file, fmt::format("has {} nodes, more than can be numbered; use a coarser mesh", map.size()));
    TetMesh mesh;
    note_warnings(file, session, mesh);
    read_positions(file, scale_m, map, mesh);
    orient_tets(file, raw, map, mesh);
    read_groups(map, raw, mesh);
    return mesh;
}

}  // namespace haptable
