// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/identity.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/hash.hpp"
#include "host/base/json.hpp"
#include "host/base/program.hpp"

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
    if (scene.vibration) {  // without these modes L is another
        hash.add(std::string("modes"));
        for (const double value : {static_cast<double>(scene.vibration->modes), scene.mass_kg()}) hash.add(value);
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
    hash.add(std::string(word(scene.contact.force)));
    hash.add(std::string(word(scene.contact.god_object)));
    hash.add(scene.contact.rigid_stiffness_n_per_m);
    const ContactOptions& c = scene.contact;
    // Only where chosen: the hash of a scene without them is what it was.
    for (const auto& [name, value] : {std::pair{"mask_radius", c.mask_radius_m},
                                      {"friction", c.static_friction},
                                      {"kinetic_friction", c.kinetic_friction},
                                      {"release_slew", c.release_n_per_ms},
                                      {"coupling", c.coupling_n_per_m},
                                      {"auto coupling", c.auto_coupling ? 1.0 : 0.0},
                                      {"passivity", c.passivity ? 1.0 : 0.0}}) {
        if (value == 0.0) continue;
        hash.add(std::string(name));
        hash.add(value);
    }
    if (c.fingers == 2) {
        hash.add(std::string("fingers"));
        hash.add(static_cast<double>(scene.tables.coupling_bytes));
    }
    if (c.auto_coupling)
        for (double value : {scene.device.damping_n_s_per_m, scene.device.friction_n, scene.device.encoder_step_m})
            hash.add(value);
    // What the stability limit follows besides, where there is any: the hash of a scene without them is what it was.
    const double scale = scene.device_map.motion_scale * scene.device_map.force_scale;
    const double delay_s = whole_delay_s(scene.device);
    if (scale != 1.0 || delay_s != 0.0)
        for (double value : {scale, delay_s}) hash.add(value);
    for (const RelaxationTerm& term : scene.relaxation)
        for (const double value : {term.share, term.time_s}) hash.add(value);
    if (scene.vibration) hash.add(scene.vibration->damping_ratio);
    if (scene.free_body) {
        const FreeBody& free = *scene.free_body;
        hash.add(free.mass_kg);
        for (const auto* six : {&free.stiffness, &free.damping}) hash.add(std::span<const double>(*six));
        if (free.floor) {
            hash.add(std::span<const double>(free.floor->normal));
            for (const double value : {free.floor->height_m, free.floor->friction}) hash.add(value);
        }
    }
    hash.add(servo_force_limit_n(scene));
    const SafetyLimits limits = servo_limits(scene);
    if (limits != SafetyLimits())
        for (const double value :
             {limits.max_speed_m_s, limits.max_force_rate_n_per_s, limits.mean_force_n, limits.mean_force_time_s,
              limits.ramp_s, limits.grab ? 1.0 : 0.0, limits.check ? 1.0 : 0.0})
            hash.add(value);
    hash.add(std::string(word(scene.tables.columns)));
    hash.add(std::string(word(scene.tables.column_precision)));
    hash.add(std::string(word(scene.tables.precision)));
    if (!scene.tables.display_rows.empty()) {
        hash.add(std::span<const std::int32_t>(scene.tables.display_rows));
        hash.add(std::string(word(scene.tables.display_precision)));
    }
    return hash.digest();
}

}  // namespace haptable
