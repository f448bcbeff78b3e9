// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/stroked_body.hpp"

#include <nlohmann/json.hpp>
#include <random>

#include "codegen/in_memory.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/base/tool_range.hpp"
#include "host/body/sample_tool.hpp"
#include "host/precompute/precompute.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr double kStaticFriction = 0.3, kKineticFriction = 0.2;
constexpr double kRelease_n_per_ms = 0.01;  // as a scene has with least energy, where the body is held
constexpr double kDensity = 1000.0, kDamping = 0.05;
constexpr int kModes = 8;
constexpr std::uintmax_t kMostCoupling = 20'000'000;

/// A mover's key in the scene, and its word in a mode's name.
struct MoverWords {
    const char *key, *word;
};
#define HAPTABLE_WORDS(PART, KEY, WORD, ...) {KEY, WORD},
constexpr MoverWords kRigid[] = {HAPTABLE_RIGID_MOVERS(HAPTABLE_WORDS)},
                     kSurface[] = {HAPTABLE_SURFACE_MOVERS(HAPTABLE_WORDS)};

}  // namespace

std::string BodyKind::name() const {
    return (motion > 0 ? std::string("-") + kRigid[motion - 1].word : "") +
           (rings ? std::string("-") + kSurface[0].word : "");
}

std::vector<TouchMode> all_modes() {
    std::vector<TouchMode> modes;
    const auto add = [&](ForceLaw force, int fingers, const BodyKind& body, bool tool) {
        for (const GodObject god_object : every<GodObject>())
            for (const bool friction : {false, true})
                modes.push_back({force, god_object, friction, fingers, body, tool});
    };
    for (const ForceLaw force : every<ForceLaw>()) {
        for (const int fingers : {1, 2})
            for (const BodyKind& body : kBodyKinds) add(force, fingers, body, false);
        if (force == ForceLaw::kInterpolated) continue;
        add(force, 1, {}, true);
        add(force, HAPTABLE_HANDS, {}, false);
    }
    return modes;
}

Scene in_mode(Scene scene, const TouchMode& mode) {
    const bool has_points = mode.tool || mode.has_hands();
    ContactOptions& contact = scene.contact;
    contact.force = mode.force;
    contact.god_object = mode.god_object;
    contact.fingers = mode.fingers;
    if (mode.force != ForceLaw::kPressureMask) contact.mask_radius_m = 0.0;
    contact.static_friction = mode.friction ? kStaticFriction : 0.0;
    contact.kinetic_friction = mode.friction ? kKineticFriction : 0.0;
    const bool releases = mode.god_object == GodObject::kLeastEnergy && mode.body.motion == 0 && !has_points;
    contact.release_n_per_ms = releases ? kRelease_n_per_ms : 0.0;
    if (mode.is_coupled()) scene.tables.coupling_bytes = kMostCoupling;
    scene.tool.reset();  // a tool's strokes have tools of their own
    scene.free_body.reset();
    scene.body_modes.reset();
    if (mode.body.rings || has_points) scene.material.stiffening.reset();  // docs/MATERIALS.md: refused
    if (mode.body.motion > 0) {
        scene.options = options_of(scene);
        scene.options.set(kRigid[mode.body.motion - 1].key, true);
        scene.free_body = FreeBody{};
        scene.free_body->density_kg_per_m3 = kDensity;
        scene.fixed.clear();
    }
    if (mode.body.rings) scene.body_modes = BodyModes{kModes, kDamping, mode.body.motion > 0 ? 0.0 : kDensity, 0.0, 0};
    return scene;
}

fs::path BodyTables::folder_of(const TouchMode& mode) const {
    return folder_ / (std::string(word(mode.force)) + (mode.is_coupled() ? "-two" : "") + mode.body.name());
}

SceneFiles BodyTables::with(const TouchMode& mode) {
    const fs::path folder = folder_of(mode);
    TouchMode other = mode;
    for (const int fingers : {1, 2})
        for (const ForceLaw force : every<ForceLaw>()) {
            other.force = force, other.fingers = fingers, other.tool = false;
            if (!fs::exists(folder) && fs::exists(folder_of(other) / "summary.json"))
                fs::copy(folder_of(other), folder, fs::copy_options::recursive);
        }
    PrecomputeOptions options;
    options.tolerance = kTolerance;
    options.code = false;
    options.inverse = &inverse_;
    Progress silent(true);
    precompute(in_mode(scene_, {mode.force, GodObject::kNearest, false, mode.is_coupled() ? 2 : 1, mode.body}), folder,
               silent, options);
    return read_scene_files(folder);
}

double BodyTables::cpu_s() const {
    double sum_s = 0.0;
    if (!fs::exists(folder_)) return sum_s;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_)) {
        if (entry.path().filename() != "summary.json") continue;
        const auto summary = parse_json(read_file(entry.path()));
        for (const auto& [stage, cpu_s] : summary.at("cpu_s").items()) sum_s += cpu_s.get<double>();
    }
    return sum_s;
}

std::vector<ToolTables> random_tools(const StrokedBody& body, const Scene& scene) {
    constexpr std::size_t kMost = 16;
    constexpr double kLargest = 1.0 / 12.0;  // of the body's size: a radius
    const double size_m = body.solid.size_m();
    std::mt19937_64 dice(kMost);
    const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(dice); };
    std::vector<ToolTables> tools;
    for (std::size_t count = kFewestPoints; count <= kMost; ++count) {
        const double radius_m = between(0.25 * kLargest, kLargest) * size_m;
        Scene with;
        with.device = scene.device;
        Tool& tool = with.tool.emplace();
        if (count % 3 != 0)
            tool.shape = ToolShape{.kind = count % 3 == 1 ? ToolShape::Kind::kDisc : ToolShape::Kind::kSphere,
                                   .points = static_cast<int>(count),
                                   .radius_m = radius_m,
                                   .angle_deg = 90.0};
        else
            std::generate_n(std::back_inserter(tool.point_m), count, [&] {
                return std::array{between(-radius_m, radius_m), between(-radius_m, radius_m),
                                  between(-radius_m, radius_m)};
            });
        complete_tool(with);
        tools.push_back({tool.point_m, tool.max_torque_n_m, 0.0, 0.0, 0.0, {}});
    }
    return tools;
}

StrokedModel::StrokedModel(const StrokedBody& body, const ContactOptions& contact, const std::vector<ToolTables>& tools)
    : body_(body) {
    const Tables& whole = body.loaded.tables();
    Tables tables;  // what a model has beside the servo's tables
    tables.force = whole.force;
    tables.max_force_n = whole.max_force_n;
    const int most = contact.fingers, least = std::min(most, HAPTABLE_FINGERS + 1);
    if (tools.empty() && most <= HAPTABLE_FINGERS) tables.stiffening = whole.stiffening;  // docs/MATERIALS.md: refused
    tables.fingers = contact.fingers;
    tables.god_object = contact.god_object;
    tables.static_friction = contact.static_friction;
    tables.kinetic_friction = contact.kinetic_friction;
    tables.options.set("contact.release_slew", contact.release_n_per_ms);
    tables.options.set("contact.passivity", contact.passivity);
    model_ = model_in_memory(tables, body.servo());
    for (int fingers = least; fingers <= most && (fingers > 1 || !tools.empty()); ++fingers) {
        pairs_.push_back(pair_in_memory(*body.loaded.coupling(), tables, model_));
        pairs_.back().finger_count = static_cast<std::uint16_t>(fingers);
    }
    for (const ToolTables& tool : tools) points_.push_back(points_of(tool));
    for (std::size_t t = 0; t < tools.size(); ++t) tools_.push_back(tool_in_memory(tools[t], points_[t], pairs_[0]));
}

}  // namespace haptable
