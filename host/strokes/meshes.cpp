// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/meshes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "firmware/haptable_pair.h"
#include "host/base/error.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"
#include "host/body/body.hpp"
#include "host/body/under_constrained.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/mesh/shells.hpp"
#include "host/mesh/write_tetgen.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using Json = nlohmann::json;  // its keys are sorted

constexpr double kLength_m = 0.1;
constexpr std::size_t kFillNodes = 3000, kMostFillNodes = 24000;
constexpr double kYoung_pa = 1e4, kPoisson = 0.3;
constexpr double kHeldShare = 0.1;
constexpr double kMaskEdges = 2.0;  // docs/CONTACT.md: keep the radius at two edges or more

bool is_scene(const fs::path& file) { return file.extension() == ".toml"; }

/// Not what only goes with a mesh: TetGen's .ele, strokes, pages.
bool may_be_body(const fs::path& file) {
    static const std::set<std::string> others{".ele", ".csv", ".md", ".fixed", ".txt", ".json"};
    return !others.contains(file.extension().string());
}

/// Scenes first, so that a mesh which has one is held as it says.
std::vector<fs::path> files_of(const fs::path& place) {
    if (!fs::exists(place)) throw Error(place.string() + ": no such file or folder; give scenes, meshes or folders");
    if (!fs::is_directory(place)) return {place};
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(place))
        if (entry.is_regular_file() && may_be_body(entry.path())) files.push_back(entry.path());
    std::ranges::sort(files, {}, [](const fs::path& file) { return std::pair(!is_scene(file), file); });
    return files;
}

/// A closed surface filled, with shorter edges where its creases are nearer to each other than these.
TetMesh fill(MeshSource source) {
    source.wrap = false;  // strokes are judged on the file's own surface
    for (source.node_count = kFillNodes;; source.node_count *= 2) try {
            return make_mesh(source);
        } catch (const Error& error) {
            const bool is_coarse = std::string(error.what()).find("more nodes") != std::string::npos;
            if (!is_coarse || source.node_count >= kMostFillNodes) throw;
        }
}

/// The mesh of a file, and what the scene says of it.
TetMesh read_any(const fs::path& file, const fs::path& folder, MeshSource& source) {
    source.file = file;
    source.linearize = true;
    try {
        return make_mesh(source);
    } catch (const Error& error) {
        if (std::string(error.what()).find("node_count") == std::string::npos) throw;
    }
    TetMesh mesh = fill(source);
    source.file = write_tetgen(mesh.position_m, mesh.tet, folder / file.stem());
    source.linearize = false;
    return mesh;
}

/// The lowest tenth of the nodes of each part, with a margin of rounding.
void hold_lowest(const TetMesh& mesh, Scene& scene) {
    std::map<std::size_t, std::vector<std::size_t>> parts;
    const std::vector<std::size_t> part = number_bodies(mesh);
    for (std::size_t i = 0; i < part.size(); ++i) parts[part[i]].push_back(i);
    for (auto& [number, nodes] : parts) {
        Eigen::AlignedBox3d box;
        for (std::size_t i : nodes) box.extend(mesh.position_m[i]);
        const auto tenth = nodes.begin() + static_cast<std::ptrdiff_t>(kHeldShare * static_cast<double>(nodes.size()));
        std::ranges::nth_element(nodes, tenth, {}, [&](std::size_t i) { return mesh.position_m[i].z(); });
        const Vector3d e = Vector3d::Constant(1e-9), low = box.min() - e, high = box.max() + e;
        const double top = mesh.position_m[*tenth].z() + e.z();
        scene.fixed.push_back({std::array{low.x(), low.y(), low.z(), high.x(), high.y(), top}, "", 1});
    }
}

/// A scene as its file has it, but touchable everywhere and at rest; a mesh as it is, 0.1 m long.
TetMesh read_body(Scene& scene, const fs::path& folder) {
    TetMesh mesh;
    if (is_scene(scene.file)) {
        mesh = make_mesh(scene.mesh);
        nlohmann::ordered_json values = scene.options.values();
        for (const char* left_out : {"touch", "gravity", "body"}) values.erase(left_out);
        scene.options = SceneOptions(std::move(values));
        scene.touch.clear();
        scene.gravity.reset();
        scene.free_body.reset();
        scene.body_modes.reset();
    } else {
        mesh = read_any(scene.file, folder, scene.mesh);
        scene.mesh.scale_m = kLength_m / audit_mesh(mesh).box_m.sizes().maxCoeff();
        for (Vector3d& p : mesh.position_m) p *= scene.mesh.scale_m;
        scene.material = {kYoung_pa, kPoisson};
    }
    if (scene.fixed.empty()) hold_lowest(mesh, scene);
    return mesh;
}

double mean_edge_m(const Body& body) {
    double sum = 0.0;
    const auto edges = edges_of(body.touch_patch);
    const auto& at = body.mesh.position_m;
    for (const auto& [edge, patches] : edges)
        sum += (at[static_cast<std::size_t>(edge[0])] - at[static_cast<std::size_t>(edge[1])]).norm();
    return sum / static_cast<double>(edges.size());
}

/// Throws Error where the body does not pass.
StrokedMesh stroked_mesh(const std::string& name, const std::string& identity, Scene scene, std::size_t most_nodes,
                         const fs::path& folder) {
    const fs::path file = scene.file;
    TetMesh mesh = read_body(scene, folder);
    scene.contact = {};
    scene.tables = {};
    scene.tables.columns = ColumnRows::kNone;
    if (mesh.position_m.size() > most_nodes)
        throw Error(fmt::format("{}: {} nodes, more than {} (--most-nodes)", file.string(), mesh.position_m.size(),
                                most_nodes));
    const Audit audit = audit_mesh(mesh);
    const Body body = make_body(scene, std::move(mesh));
    const std::vector<std::int32_t> loose = find_under_constrained(body);
    if (!loose.empty()) throw Error(fmt::format("{}: {}", file.string(), describe_under_constrained(loose, body)));
    scene.contact.mask_radius_m = kMaskEdges * mean_edge_m(body);
    const bool is_filled = !is_scene(file) && scene.mesh.file != file;
    return {.name = name,
            .identity = identity,
            .scene = std::move(scene),
            .filled = is_filled,
            .nodes = body.mesh.position_m.size(),
            .patches = body.touch_patch.size(),
            .parts = audit.bodies};
}

/// What tells a mesh from another: its bytes, or how it is generated.
std::string identity_of(const MeshSource& source) {
    Hash hash;
    if (!source.generate.empty())
        hash.add(fmt::format("{} {} {}", source.generate, source.nodes_per_side, source.side_m));
    else
        for (const fs::path& part : mesh_files(source.file)) hash.add(hash_file(part));
    return hash.text();
}

/// A value as TOML has it.
std::string toml_of(const Json& value) {
    if (!value.is_object()) return json_text(value);
    std::vector<std::string> keys;
    for (const auto& [key, of] : value.items()) keys.push_back(key + " = " + toml_of(of));
    return fmt::format("{{ {} }}", fmt::join(keys, ", "));
}

}  // namespace

std::uintmax_t StrokedMesh::coupling_bytes(ForceLaw force) const {
    const std::uintmax_t vertices = patches / 2 + 2, edges = patches + patches / 2;  // Euler's, of a ball
    const std::uintmax_t controls = force == ForceLaw::kPressureMask ? vertices + edges : vertices;
    return controls * (controls + 1) / 2 * sizeof(haptable_float9);
}

StrokedMeshes collect_meshes(const std::vector<fs::path>& places, const std::vector<std::string>& only,
                             std::size_t most_nodes, const fs::path& folder) {
    StrokedMeshes meshes;
    std::map<std::string, std::string> seen;  // names by identities
    for (const fs::path& place : places)
        for (const fs::path& file : files_of(place)) try {
                Scene scene;
                if (is_scene(file))
                    scene = read_scene(file);
                else
                    scene.file = scene.mesh.file = file;
                if (scene.mesh.generate.empty()) scene.name = scene.mesh.file.stem();
                const std::string name = scene.name;
                const auto is_in_name = [&](const std::string& part) { return name.find(part) != std::string::npos; };
                if (!only.empty() && std::ranges::none_of(only, is_in_name)) continue;
                const std::string identity = identity_of(scene.mesh);
                const auto [first, is_new] = seen.try_emplace(identity, name);
                if (is_new)
                    meshes.taken.push_back(stroked_mesh(name, identity, std::move(scene), most_nodes, folder));
                else if (first->second != name)  // else a scene and its mesh, or a copy
                    meshes.left_out.push_back(
                        {name, fmt::format("{}: the same mesh as {}", file.string(), first->second)});
            } catch (const Error& error) {
                meshes.left_out.push_back({file.stem(), error.what()});
            }
    return meshes;
}

std::string to_toml(const Scene& scene) {
    Json values(options_of(scene).values());
    const bool is_file = scene.mesh.generate.empty();
    if (is_file) values["mesh"]["file"] = fs::absolute(scene.mesh.file).string();
    for (const char* other : {is_file ? "nodes_per_side" : "scale", is_file ? "side" : "linearize"})
        values["mesh"].erase(other);
    if (scene.fixed.empty()) values.erase("fixed");
    if (!values.contains("fixed"))
        for (const Selection& fixed : scene.fixed) values["fixed"].push_back({{"box", *fixed.box_m}});
    for (const char* key : {"mask_radius", "kinetic_friction"})  // 0 is for what is not there
        if (values["contact"].contains(key) && values["contact"][key] == 0.0) values["contact"].erase(key);
    if (scene.tool) values["tool"] = {{"max_torque", scene.tool->max_torque_n_m}, {"points", scene.tool->point_m}};
    values["device"] = {{"max_force", scene.device.max_force_n}};
    values["tables"] = {{"columns", "none"}};
    if (scene.contact.fingers > 1 || scene.tool) values["tables"]["coupling_bytes"] = scene.tables.coupling_bytes;
    std::string text = fmt::format("name = \"{}\"\n", scene.name);
    for (const char* name : {"mesh", "material", "region", "fixed", "contact", "body", "tool", "device", "tables"}) {
        if (!values.contains(name)) continue;
        const Json& section = values[name];
        for (const Json& table : section.is_array() ? section : Json::array({section})) {
            text += section.is_array() ? fmt::format("\n[[{}]]\n", name) : fmt::format("\n[{}]\n", name);
            for (const auto& [key, value] : table.items()) text += key + " = " + toml_of(value) + "\n";
        }
    }
    return text;
}

}  // namespace haptable
