// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/identity.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/hash.hpp"
#include "host/base/json.hpp"
#include "host/base/program.hpp"
#include "host/scene/keys.hpp"

namespace haptable {

namespace {

void add(const Material& material, Hash& hash) {
    hash.add(material.young_pa);
    hash.add(material.poisson);
    if (!material.orthotropic) return;
    for (const auto* three :
         {&material.orthotropic->young_pa, &material.orthotropic->poisson, &material.orthotropic->shear_pa})
        hash.add(std::span<const double>(*three));
}

/// Version, mesh, element and fixed nodes.
void add_mesh(const Scene& scene, const Body& body, Hash& hash) {
    hash.add(std::string(kVersion));
    for (const Eigen::Vector3d& p : body.mesh.position_m) hash.add(std::span<const double>(p.data(), 3));
    hash.add(std::span<const Tet>(body.mesh.tet));
    hash.add(std::span<const std::int32_t>(body.unknown));  // -1 marks the fixed nodes
    // Only where chosen: the hash of linear tetrahedra is what it was.
    if (scene.mesh.element != Element::kLinear) hash.add(std::string(word(scene.mesh.element)));
    if (!body.mesh.middle.empty()) hash.add(std::span<const MiddleNodes>(body.mesh.middle));
}

void add_materials(const Scene& scene, const Body& body, Hash& hash) {
    hash.add(std::span<const std::int32_t>(body.region));
    add(scene.material, hash);
    for (const Region& region : scene.regions) add(region.material, hash);
    for (const Eigen::Matrix3d& axes : body.axes) hash.add(std::span<const double>(axes.data(), 9));
    for (const LayeredFace& face : body.layered) {
        const Layer& l = face.layer;
        hash.add(nodes_of(face));
        for (double value : {l.lambda_n_per_m, l.mu_n_per_m, l.normal_n_per_m3, l.tangential_n_per_m3}) hash.add(value);
    }
    if (scene.free_body) {  // how its weight is distributed; the elastic part has no unit of it
        hash.add(std::string("free"));
        hash.add(scene.density_of(-1));
        for (std::size_t r = 0; r < scene.regions.size(); ++r) hash.add(scene.density_of(static_cast<std::int32_t>(r)));
    }
    if (scene.body_modes) {  // without these modes L is another
        hash.add(std::string("modes"));
        for (const double value : {static_cast<double>(scene.body_modes->modes), scene.mass_kg()}) hash.add(value);
        for (std::int32_t r = -1; r < static_cast<std::int32_t>(scene.regions.size()); ++r)
            hash.add(scene.density_of(r));
    }
    if (!scene.gravity) return;
    hash.add(std::string(scene.gravity->prestress ? "gravity with prestress" : "gravity"));
    hash.add(std::span<const double>(scene.gravity->acceleration_m_per_s2));
    hash.add(scene.gravity->density_kg_per_m3);
    for (std::size_t r = 0; r < scene.regions.size(); ++r) hash.add(scene.density_of(static_cast<std::int32_t>(r)));
}

}  // namespace

std::string program_hash() { return hash_file("/proc/self/exe"); }

nlohmann::ordered_json to_json(const Scene& scene, const Identity& identity) {
    return {{"name", scene.name},
            {"scene", scene.file.filename().string()},
            {"model_hash", fmt::format("{:016x}", identity.model_hash)},
            {"haptable_version", kVersion},
            {"program", program_hash()},
            {"tolerance", identity.tolerance},
            {"column_tolerance", identity.column_tolerance},
            {"drawing", identity.drawing}};
}

std::string options_text(const Scene& scene) {
    SceneOptions options = options_of(scene);
    options.set("scene", scene.file.filename().string());
    return json_text(options.values(), 1) + "\n";
}

std::uint64_t hash_body(const Scene& scene, const Body& body) {
    Hash hash;
    add_mesh(scene, body, hash);
    add_materials(scene, body, hash);
    return hash.digest();
}

std::uint64_t hash_work(const Scene& scene, const Identity& identity, const std::string& precision, double unit_m_per_n,
                        std::span<const std::int32_t> node, std::span<const std::int32_t> row) {
    Hash hash;
    hash.add(json_text(to_json(scene, identity)));
    hash.add(precision);
    hash.add(unit_m_per_n);
    hash.add(node);
    hash.add(row);
    return hash.digest();
}

std::uint64_t hash_model(const Scene& scene, const Body& body) {
    Hash hash;
    add_mesh(scene, body, hash);
    hash.add(std::span<const Patch>(body.touch_patch));
    add_materials(scene, body, hash);
    hash.add(text_of_tables(options_of(scene)));
    return hash.digest();
}

}  // namespace haptable
