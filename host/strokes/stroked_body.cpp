// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/stroked_body.hpp"

#include <nlohmann/json.hpp>

#include "codegen/in_memory.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/precompute/precompute.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr double kStaticFriction = 0.3, kKineticFriction = 0.2;
constexpr double kRelease_n_per_ms = 0.01;  // as a scene has with least energy

Tables computed(const Scene& scene, const fs::path& folder, Progress& progress) {
    precompute(scene, folder, progress);
    return read_tables(folder);
}

}  // namespace

std::vector<TouchMode> all_modes() {
    std::vector<TouchMode> modes;
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god_object : every<GodObject>())
            for (bool friction : {false, true}) modes.push_back({force, god_object, friction});
    return modes;
}

Scene in_mode(Scene scene, const TouchMode& mode) {
    ContactOptions& contact = scene.contact;
    contact.force = mode.force;
    contact.god_object = mode.god_object;
    if (mode.force != ForceLaw::kPressureMask) contact.mask_radius_m = 0.0;
    contact.static_friction = mode.friction ? kStaticFriction : 0.0;
    contact.kinetic_friction = mode.friction ? kKineticFriction : 0.0;
    contact.release_n_per_ms = mode.god_object == GodObject::kLeastEnergy ? kRelease_n_per_ms : 0.0;
    return scene;
}

Tables BodyTables::with(ForceLaw force) {
    const fs::path folder = folder_of(force);
    for (const ForceLaw other : kForcesOfTables)
        if (!fs::exists(folder) && fs::exists(folder_of(other) / "summary.json"))
            fs::copy(folder_of(other), folder, fs::copy_options::recursive);
    PrecomputeOptions options;
    options.tolerance = kTolerance;
    options.inverse = &inverse_;
    Progress silent(true);
    precompute(in_mode(scene_, {force, GodObject::kNearest, false}), folder, silent, options);
    return read_tables(folder);
}

double BodyTables::cpu_s() const {
    double sum_s = 0.0;
    for (const ForceLaw force : kForcesOfTables) {
        const fs::path file = folder_of(force) / "summary.json";
        if (!fs::exists(file)) continue;
        const auto summary = parse_json(read_file(file));
        for (const auto& [stage, cpu_s] : summary.at("cpu_s").items()) sum_s += cpu_s.get<double>();
    }
    return sum_s;
}

StrokedBody::StrokedBody(const Scene& scene, const fs::path& folder, Progress& progress)
    : StrokedBody(computed(scene, folder, progress)) {}

StrokedBody::StrokedBody(Tables tables)
    : tables_(std::move(tables)),
      servo_(build_model(tables_)),
      solid_(servo_.vertex_m, servo_.patch),
      law_(tables_, servo_) {}

haptable_model StrokedBody::model(const ContactOptions& contact) const {
    Tables tables;  // what a model has beside the servo's tables
    tables.force = tables_.force;
    tables.model_hash = tables_.model_hash;
    tables.max_force_n = tables_.max_force_n;
    tables.god_object = contact.god_object;
    tables.static_friction = contact.static_friction;
    tables.kinetic_friction = contact.kinetic_friction;
    tables.release_n_per_ms = contact.release_n_per_ms;
    tables.passivity = contact.passivity;
    return model_in_memory(tables, servo_);
}

}  // namespace haptable
