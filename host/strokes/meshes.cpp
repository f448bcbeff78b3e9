// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/meshes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "firmware/haptable_pair.h"
#include "firmware/haptable_scene.h"
#include "host/base/error.hpp"
#include "host/base/hash.hpp"
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

constexpr double kLength_m = 0.1;
constexpr std::size_t kFillNodes = 3000, kMostFillNodes = 24000;
constexpr double kYoung_pa = 1e4, kPoisson = 0.3;
constexpr double kHeldShare = 0.1;
constexpr double kMaskEdges = 2.0;  // docs/CONTACT.md: keep the radius at two edges or more

bool is_scene(const fs::path& file) { return file.extension() == ".toml"; }

/// Not what only goes with a mesh: TetGen's .ele, strokes, pages.
bool may_be_mesh(const fs::path& file) {
    static const std::set<std::string> others{".toml", ".ele", ".csv", ".md", ".fixed", ".txt", ".json"};
    return !others.contains(file.extension().string());
}

/// Scenes first, so that a mesh which has one is held as it says.
std::vector<fs::path> files_of(const fs::path& place) {
    if (!fs::exists(place)) throw Error(place.string() + ": no such file or folder; give scenes, meshes or folders");
    if (!fs::is_directory(place)) return {place};
    std::vector<fs::path> scenes, meshes;
    for (const fs::directory_entry& entry : fs::directory_iterator(place)) {
        if (!entry.is_regular_file()) continue;
        if (is_scene(entry.path())) scenes.push_back(entry.path());
        if (may_be_mesh(entry.path())) meshes.push_back(entry.path());
    }
    std::sort(scenes.begin(), scenes.end());
    std::sort(meshes.begin(), meshes.end());
    scenes.insert(scenes.end(), meshes.begin(), meshes.end());
    return scenes;
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
        std::vector<double> z;
        for (std::size_t i : nodes) z.push_back(mesh.position_m[i].z());
        const auto tenth = static_cast<std::size_t>(kHeldShare * static_cast<double>(z.size()));
        std::nth_element(z.begin(), z.begin() + static_cast<std::ptrdiff_t>(tenth), z.end());
        const double e = 1e-9;
        scene.fixed.push_back({std::array{box.min().x() - e, box.min().y() - e, box.min().z() - e, box.max().x() + e,
                                          box.max().y() + e, z[tenth] + e},
                               "", 1});
    }
}

void scale(TetMesh& mesh, double by) {
    for (Vector3d& p : mesh.position_m) p *= by;
}

Scene scene_of_mesh(const fs::path& file, const fs::path& folder, TetMesh& mesh) {
    Scene scene;
    scene.file = file;
    scene.name = file.stem();
    mesh = read_any(file, folder, scene.mesh);
    scene.mesh.scale_m = kLength_m / audit_mesh(mesh).box_m.sizes().maxCoeff();
    scale(mesh, scene.mesh.scale_m);
    scene.material = {kYoung_pa, kPoisson};
    hold_lowest(mesh, scene);
    return scene;
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
StrokedMesh stroked_mesh(const fs::path& file, std::size_t most_nodes, const fs::path& folder) {
    StrokedMesh stroked;
    TetMesh mesh;
    Scene& scene = stroked.scene;
    if (is_scene(file)) {
        scene = read_scene(file);
        mesh = make_mesh(scene.mesh);
        scene.touch.clear();
        scene.gravity.reset();
        scene.free_body.reset();
        scene.body_modes.reset();
        if (scene.fixed.empty()) hold_lowest(mesh, scene);
    } else {
        scene = scene_of_mesh(file, folder, mesh);
        stroked.filled = scene.mesh.file != file;
    }
    scene.name = scene.mesh.generate.empty() ? scene.mesh.file.stem().string() : scene.name;
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
    const std::vector<std::size_t> part = number_bodies(body.mesh);
    stroked.parts = part.empty() ? 0 : 1 + *std::max_element(part.begin(), part.end());
    stroked.name = scene.name;
    stroked.nodes = body.mesh.position_m.size();
    stroked.patches = body.touch_patch.size();
    stroked.hinges = audit.hinge_edges + audit.hinge_nodes;
    return stroked;
}

/// What tells a mesh from another: its bytes, or how it is generated.
std::string identity_of(const fs::path& file) {
    Hash hash;
    const MeshSource source = is_scene(file) ? read_scene(file).mesh : MeshSource();
    if (!source.generate.empty())
        hash.add(fmt::format("{} {} {}", source.generate, source.nodes_per_side, source.side_m));
    else
        for (const fs::path& part : mesh_files(is_scene(file) ? source.file : file)) hash.add(hash_file(part));
    return hash.text();
}

bool is_wanted(const std::string& name, const std::vector<std::string>& only) {
    return only.empty() || std::any_of(only.begin(), only.end(),
                                       [&](const std::string& part) { return name.find(part) != std::string::npos; });
}

/// Its [body], of those that in_mode makes.
std::string body_of(const Scene& scene) {
    std::string text = scene.free_body ? "free = true\n" : "";
    for (const std::string key : {
#define HAPTABLE_KEY(PART, KEY, ...) KEY,
             HAPTABLE_RIGID_MOVERS(HAPTABLE_KEY)})
        if (key != "body.free" && scene.free_body && scene.options.flag(key))
            text += key.substr(key.find('.') + 1) + " = true\n";
    const double density = scene.free_body ? scene.free_body->density_kg_per_m3 : scene.body_modes->density_kg_per_m3;
    text += fmt::format("density = {:.17g}\n", density);
    if (scene.body_modes)
        text += fmt::format("modes = {}\nmode_damping = {:.17g}\n", scene.body_modes->modes,
                            scene.body_modes->damping_ratio);
    return text;
}

/// As far as it can be told without reading the mesh.
std::string name_of(const fs::path& file) {
    if (!is_scene(file)) return file.stem();
    const Scene scene = read_scene(file);
    return scene.mesh.generate.empty() ? scene.mesh.file.stem().string() : scene.name;
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
                const std::string name = name_of(file);
                if (!is_wanted(name, only)) continue;
                const std::string identity = identity_of(file);
                const auto [first, is_new] = seen.try_emplace(identity, name);
                if (!is_new) {  // of one name: a scene and its mesh, or a copy
                    const std::string why = fmt::format("{}: the same mesh as {}", file.string(), first->second);
                    if (first->second != name) meshes.left_out.push_back({name, why});
                    continue;
                }
                StrokedMesh mesh = stroked_mesh(file, most_nodes, folder);
                mesh.identity = identity;
                meshes.taken.push_back(std::move(mesh));
            } catch (const Error& error) {
                meshes.left_out.push_back({file.stem(), error.what()});
            }
    return meshes;
}

std::string to_toml(const Scene& scene) {
    const auto box = [](const Selection& where) {
        if (where.below)
            return fmt::format("below = {:.17g}\naxis = \"{}{}\"", where.below->depth_m,
                               where.below->is_turned ? "-" : "", "xyz"[where.below->axis]);
        return where.box_m ? fmt::format("box = [{:.17g}]", fmt::join(*where.box_m, ", "))
                           : fmt::format("group = \"{}\"", where.group);
    };
    std::string text = fmt::format("name = \"{}\"\n\n[mesh]\n", scene.name);
    const MeshSource& mesh = scene.mesh;
    if (mesh.generate.empty()) {
        text += fmt::format("file = \"{}\"\nscale = {:.17g}\n", fs::absolute(mesh.file).string(), mesh.scale_m);
        if (mesh.linearize) text += "linearize = true\n";
        if (mesh.node_count > 0) text += fmt::format("node_count = {}\n", mesh.node_count);
        if (mesh.wrap) text += fmt::format("wrap = {}\n", *mesh.wrap);
        if (mesh.edge_length_m > 0.0) text += fmt::format("edge_length = {:.17g}\n", mesh.edge_length_m);
    } else {
        text += fmt::format("generate = \"{}\"\nnodes_per_side = {}\nside = {:.17g}\n", mesh.generate,
                            mesh.nodes_per_side, mesh.side_m);
    }
    text += fmt::format("\n[material]\nyoung = {:.17g}\npoisson = {:.17g}\n", scene.material.young_pa,
                        scene.material.poisson);
    if (const auto& stiffens = scene.material.stiffening)
        text += stiffens->curve.energy_j > 0.0
                    ? fmt::format("stiffening = {{ curve = [{:.17g}], energy = {:.17g} }}\n",
                                  fmt::join(stiffens->curve.c, ", "), stiffens->curve.energy_j)
                : stiffens->fung > 0.0
                    ? fmt::format("stiffening = {{ fung = {:.17g} }}\n", stiffens->fung)
                    : fmt::format("stiffening = {{ yeoh = [{:.17g}, {:.17g}] }}\n", stiffens->y2, stiffens->y3);
    for (const Region& region : scene.regions)
        text += fmt::format("\n[[region]]\n{}\nyoung = {:.17g}\npoisson = {:.17g}\n", box(region.where),
                            region.material.young_pa, region.material.poisson);
    for (const Selection& fixed : scene.fixed) text += fmt::format("\n[[fixed]]\n{}\n", box(fixed));
    const ContactOptions& contact = scene.contact;
    text += fmt::format("\n[contact]\nforce = \"{}\"\ngod_object = \"{}\"\nrigid_stiffness = {:.17g}\n",
                        word(contact.force), word(contact.god_object), contact.rigid_stiffness_n_per_m);
    if (contact.fingers == 2) text += "fingers = 2\n";
    if (contact.mask_radius_m > 0.0) text += fmt::format("mask_radius = {:.17g}\n", contact.mask_radius_m);
    if (contact.static_friction > 0.0)
        text += fmt::format("friction = {:.17g}\nkinetic_friction = {:.17g}\n", contact.static_friction,
                            contact.kinetic_friction);
    if (scene.free_body || scene.body_modes) text += "\n[body]\n" + body_of(scene);
    if (scene.tool) {
        text += fmt::format("\n[tool]\nmax_torque = {:.17g}\npoints = [", scene.tool->max_torque_n_m);
        for (const auto& r : scene.tool->point_m) text += fmt::format("[{:.17g}], ", fmt::join(r, ", "));
        text += "]\n";
    }
    text += fmt::format("\n[device]\nmax_force = {:.17g}\n\n[tables]\ncolumns = \"none\"\n", scene.device.max_force_n);
    if (contact.fingers == 2 || scene.tool) text += fmt::format("coupling_bytes = {}\n", scene.tables.coupling_bytes);
    return text;
}

}  // namespace haptable
