// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "host/base/error.hpp"
#include "host/base/limits.hpp"
#include "host/scene/device_models.hpp"
#include "host/scene/keys.hpp"
#include "host/scene/read_material.hpp"
#include "host/scene/read_options.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// ---- keys and members ----------------------------------------------------------------------------------------------

/// Members from keys.
struct Load {
    const SceneOptions& from;

    template <typename Member>
    void operator()(const char* key, Member& to) const {
        if (from.has(key)) from.at(key).get_to(to);
    }
    template <typename Choice>
    requires std::is_enum_v<Choice>
    void operator()(const char* key, Choice& to) const {
        if (from.has(key)) to = from.choice<Choice>(key);
    }
    template <typename Member>
    void operator()(const char* key, std::optional<Member>& to) const {
        if (from.has(key)) to = from.at(key).get<Member>();
    }
};

/// Keys from members. A member that is 0 does not name a key that has no default.
struct Store {
    SceneOptions& to;

    template <typename Member>
    void operator()(const char* key, const Member& from) const {
        if (from != Member() || to.has(key)) to.set(key, from);
    }
    template <typename Choice>
    requires std::is_enum_v<Choice>
    void operator()(const char* key, const Choice& from) const { to.set(key, word(from)); }
    template <typename Member>
    void operator()(const char* key, const std::optional<Member>& from) const {
        if (from) to.set(key, *from);
    }
};

/// [body]'s members that are there.
template <typename Of, typename Visit>
void visit_body(Of& scene, const Visit& visit) {
    if (scene.free_body) {
        auto& body = *scene.free_body;
        visit("body.density", body.density_kg_per_m3);
        visit("body.mass", body.mass_kg);
        visit("body.suspension", body.stiffness);
        visit("body.suspension_damping", body.damping);
        if (body.floor) {
            visit("body.floor", body.floor->height_m);
            visit("body.floor_normal", body.floor->normal);
            visit("body.floor_friction", body.floor->friction);
        }
    }
    if (!scene.body_modes) return;
    visit("body.modes", scene.body_modes->modes);
    visit("body.mode_damping", scene.body_modes->damping_ratio);
    if (scene.free_body) return;
    visit("body.density", scene.body_modes->density_kg_per_m3);
    visit("body.mass", scene.body_modes->mass_kg);
}

template <typename Of, typename Visit>
void visit_device(Of& device, const Visit& visit) {
    visit("device.max_force", device.max_force_n);
    visit("device.mass", device.mass_kg);
    visit("device.damping", device.damping_n_s_per_m);
    visit("device.friction", device.friction_n);
    visit("device.encoder_step", device.encoder_step_m);
    visit("device.bandwidth", device.bandwidth_hz);
    visit("device.delay", device.delay_s);
    visit("device.max_speed", device.limits.max_speed_m_s);
    visit("device.max_force_rate", device.limits.max_force_rate_n_per_s);
    visit("device.mean_force", device.limits.mean_force_n);
    visit("device.mean_force_time", device.limits.mean_force_time_s);
    visit("device.ramp_time", device.limits.ramp_s);
    visit("tables.check", device.limits.check);
}

/// Every key that has a member.
template <typename Of, typename Visit>
void visit_members(Of& scene, const Visit& visit) {
    visit("name", scene.name);
    visit("mesh.element", scene.mesh.element);
    visit("mesh.generate", scene.mesh.generate);
    visit("mesh.nodes_per_side", scene.mesh.nodes_per_side);
    visit("mesh.side", scene.mesh.side_m);
    visit("mesh.scale", scene.mesh.scale_m);
    visit("mesh.linearize", scene.mesh.linearize);
    visit("mesh.edge_length", scene.mesh.edge_length_m);
    visit("mesh.node_count", scene.mesh.node_count);
    visit("mesh.wrap", scene.mesh.wrap);
    visit("contact.force", scene.contact.force);
    visit("contact.mask_radius", scene.contact.mask_radius_m);
    visit("contact.god_object", scene.contact.god_object);
    visit("contact.rigid_stiffness", scene.contact.rigid_stiffness_n_per_m);
    visit("contact.friction", scene.contact.static_friction);
    visit("contact.kinetic_friction", scene.contact.kinetic_friction);
    visit("contact.release_slew", scene.contact.release_n_per_ms);
    visit("contact.passivity", scene.contact.passivity);
    visit("contact.grab", scene.contact.grab);
    visit("contact.fingers", scene.contact.fingers);
    visit_device(scene.device, visit);
    visit("device.model", scene.device.model);
    visit("device.position", scene.device_map.position_m);
    visit("device.rotation", scene.device_map.rotation_deg);
    visit("device.motion_scale", scene.device_map.motion_scale);
    visit("device.force_scale", scene.device_map.force_scale);
    visit("device.clutch_ramp", scene.device_map.ramp_s);
    visit("device.workspace", scene.device_map.workspace_m);
    visit("tables.precision", scene.tables.precision);
    visit("tables.columns", scene.tables.columns);
    visit("tables.column_precision", scene.tables.column_precision);
    visit("tables.column_budget", scene.tables.column_budget_bytes);
    visit("tables.flash_budget", scene.tables.flash_budget);
    visit("tables.coupling_bytes", scene.tables.coupling_bytes);
    visit("tables.display_rows", scene.tables.display_rows);
    visit("tables.display_precision", scene.tables.display_precision);
    visit_body(scene, visit);
    if (!scene.tool) return;
    visit("tool.max_torque", scene.tool->max_torque_n_m);
    visit("tool.stiffness", scene.tool->stiffness_n_per_m);
    visit("tool.turn_stiffness", scene.tool->turn_stiffness_n_m_per_rad);
}

// ---- what more than one key says ----------------------------------------------------------------------------------

/// Folders that make fills beside those of the scenes.
constexpr std::string_view kTaken[] = {
    "against", "bin",      "codegen", "contact",  "demo", "error",   "figures", "firmware", "fuzz",  "hard",
    "host",    "lab",      "large",   "lcm",      "lib",  "masks",   "modes",   "package",  "peers", "python",
    "quick",   "realtime", "report",  "sanitize", "scan", "strokes", "tests",   "tidy",     "units", "ways"};

/// The name is a folder's, a C identifier's (after codegen has mended it) and a message's.
void check_name(const Section& root, const std::string& name) {
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    const auto inner = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
    if (name.empty() || name.size() > 64 || !letter(name[0]) || !std::all_of(name.begin(), name.end(), inner))
        root.fail("name", "must be a letter and then at most 63 letters, digits, '_' and '-'");
    if (std::find(std::begin(kTaken), std::end(kTaken), name) != std::end(kTaken))
        root.fail("name", fmt::format("\"{}\" is a folder of the build itself: choose another", name));
}

std::vector<Selection> read_selections(const Section& root, const SceneOptions& options, const char* name) {
    std::vector<Selection> selections;
    for (const Section& section : root.sections(name)) {
        const Json& values = options.at(name).at(selections.size());
        Selection selection;
        selection.group = values.value("group", "");
        selection.line = section.line();
        if (values.contains("box")) selection.box_m = values["box"].get<std::array<double, 6>>();
        selection.cavities = values.value("cavities", false);
        const std::string axis = values.value("axis", "z");
        if (values.contains("below")) selection.below = Below{values["below"], axis.back() - 'x', axis.front() == '-'};
        selections.push_back(std::move(selection));
    }
    return selections;
}

std::vector<Region> read_regions(const Section& root, const SceneOptions& options, Element element) {
    std::vector<Region> regions;
    const std::vector<Section> sections = root.sections("region");
    for (const Selection& where : read_selections(root, options, "region")) {
        const Json& values = options.at("region").at(regions.size());
        regions.push_back({where, read_material(sections[regions.size()], element)});
        if (values.contains("density")) regions.back().density_kg_per_m3 = values["density"].get<double>();
    }
    return regions;
}

std::vector<Membrane> read_membranes(const Section& root, const SceneOptions& options) {
    std::vector<Membrane> membranes;
    for (const Selection& where : read_selections(root, options, "membrane")) {
        const Json& values = options.at("membrane").at(membranes.size());
        membranes.push_back({where, values["thickness"], values["young"], values["poisson"]});
    }
    return membranes;
}

std::vector<Bed> read_beds(const Section& root, const SceneOptions& options) {
    std::vector<Bed> beds;
    for (const Selection& where : read_selections(root, options, "bed")) {
        const Json& values = options.at("bed").at(beds.size());
        beds.push_back({where, values["normal"], values["tangential"]});
    }
    return beds;
}

constexpr std::size_t kMostTerms = 8;  // HAPTABLE_TERMS: the servo's state

std::vector<RelaxationTerm> read_relaxation(const Section& root, const SceneOptions& options) {
    std::vector<RelaxationTerm> terms;
    for (const Section& section : root.sections("relaxation")) {
        const Json& values = options.at("relaxation").at(terms.size());
        terms.push_back({values["share"], values["time"]});
        if (!(rest_share(terms) > 1e-6))
            section.fail("share",
                         fmt::format("brings the sum of all shares to {:g}, and a body whose stiffness relaxes "
                                     "to nothing flows: keep the sum below 1",
                                     1.0 - rest_share(terms)));
        if (terms.size() > kMostTerms)
            section.fail("time", fmt::format("is of term {}, and a servo has at most {}", terms.size(), kMostTerms));
    }
    return terms;
}

std::optional<Gravity> read_gravity(const SceneOptions& options) {
    if (!options.has("gravity")) return {};
    Gravity gravity{.density_kg_per_m3 = options.number("gravity.density"),
                    .prestress = options.flag("gravity.prestress")};
    const std::vector<double> d = options.numbers("gravity.direction");
    const double scale = options.number("gravity.acceleration") / std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (std::size_t c = 0; c < 3; ++c) gravity.acceleration_m_per_s2[c] = scale * d[c];
    return gravity;
}

/// What [body] makes of the scene, without its numbers.
void begin_body(const Section& root, const SceneOptions& options, Scene& scene) {
    if (!options.has("body")) return;
    const Section section = root.section("body", false);
    if (options.flag("body.free")) {
        scene.free_body.emplace();
        scene.free_body->line = section.line("free");
        if (options.has("body.floor")) scene.free_body->floor = FreeBody::Floor{};
    }
    if (options.integer("body.modes") == 0) return;
    scene.body_modes.emplace();
    scene.body_modes->line = section.line("modes");
}

std::optional<Tool> begin_tool(const Section& root, const SceneOptions& options) {
    if (!options.has("tool")) return {};
    Tool tool;
    tool.line = root.section("tool", false).line();
    return tool;
}

/// Its points, or the shape that has them.
void finish_tool(const Section& root, const fs::path& scene_file, const SceneOptions& options, Tool& tool) {
    const std::string kind = options.text("tool.shape");
    const bool is_listed = options.at("tool.points").is_array();
    if (is_listed != (kind == "points"))
        root.section("tool", false)
            .fail("points", is_listed
                                ? "are given one by one, and there is a shape too: give their number, or remove shape"
                                : "is a number: give the shape that has so many, or a list of points");
    if (is_listed) {
        tool.point_m = options.at("tool.points").get<std::vector<std::array<double, 3>>>();
        return;
    }
    using Kind = ToolShape::Kind;
    ToolShape& shape = tool.shape.emplace();
    shape.kind = kind == "sphere"    ? Kind::kSphere
                 : kind == "capsule" ? Kind::kCapsule
                 : kind == "disc"    ? Kind::kDisc
                                     : Kind::kMesh;
    shape.points = static_cast<int>(options.integer("tool.points"));
    shape.radius_m = options.number_or("tool.radius", 0.0);
    shape.length_m = options.number_or("tool.length", 0.0);
    shape.angle_deg = options.number_or("tool.angle", shape.angle_deg);
    if (options.has("tool.file")) shape.file = scene_file.parent_path() / options.text("tool.file");
    shape.scale_m = options.number_or("tool.scale", 1.0);
}

/// As the file says, else against gravity, else z; of length 1.
void finish_floor(const SceneOptions& options, const std::optional<Gravity>& gravity, FreeBody::Floor& floor) {
    auto& normal = floor.normal;
    if (gravity && !options.has("body.floor_normal"))
        for (std::size_t c = 0; c < 3; ++c) normal[c] = -gravity->acceleration_m_per_s2[c];
    const double length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (double& n : normal) n /= length;
}

/// Cell vectors that any material is turned by: what the mesh's reader must keep.
void collect_directions(Scene& scene) {
    const auto collect = [&](const Material& material) {
        if (!material.orthotropic) return;
        for (const std::string& field : material.orthotropic->axes.field)
            if (!field.empty()) scene.mesh.directions.push_back(field);
    };
    collect(scene.material);
    for (const Region& region : scene.regions) collect(region.material);
    if (!scene.mesh.directions.empty() && !scene.mesh.generate.empty())
        throw Error(fmt::format("{}: cell vectors belong to a mesh file, and the cube is generated; give axes",
                                scene.file.string()));
}

/// {law, young, poisson} or the nine constants.
Json to_json(const Material& material) {
    if (!material.orthotropic)
        return {{"law", "isotropic"}, {"young", material.young_pa}, {"poisson", material.poisson}};
    const Orthotropic& law = *material.orthotropic;
    return {{"law", "orthotropic"}, {"young", law.young_pa}, {"poisson", law.poisson}, {"shear", law.shear_pa}};
}

Json to_json(const Stiffening& stiffening) {
    const auto& [y2, y3, fung, curve, press] = stiffening;
    if (fung > 0.0) return {{"fung", fung}};
    if (!(curve.energy_j > 0.0)) return {{"yeoh", {y2, y3}}};
    Json json{{"curve", curve.c}, {"energy", curve.energy_j}};
    if (press)
        json.update({{"at", press->at_m},
                     {"radius", press->radius_m},
                     {"depth", press->depth_m},
                     {"stiffness", press->stiffness_n_per_m}});
    return json;
}

/// A material's constants over what the file says of it: its place and its axes stay.
void store(const Material& material, Json& values) {
    const Json constants = to_json(material);
    for (const auto& [key, value] : constants.items()) values[key] = value;
    for (const char* key : {"young_along", "young_across", "poisson_across", "stiffening"}) values.erase(key);
    if (material.stiffening) values["stiffening"] = to_json(*material.stiffening);
}

}  // namespace

double servo_force_limit_n(const Scene& scene) { return scene.device.max_force_n / scene.device_map.force_scale; }

double whole_delay_s(const Device& device) { return whole_delay_s(device.delay_s, device.bandwidth_hz); }

SafetyLimits servo_limits(const Scene& scene) {
    return at_body(scene.device.limits, scene.device_map.motion_scale, scene.device_map.force_scale);
}

SceneOptions options_of(const Scene& scene) {
    SceneOptions options = scene.options.has("contact") ? scene.options : default_options();
    if (scene.free_body || scene.body_modes) {
        options.set("body.free", scene.free_body.has_value());
        options.set("body.modes", 0);
    }
    visit_members(scene, Store{options});
    options.set("contact.coupling", scene.contact.auto_coupling            ? Json("auto")
                                    : scene.contact.coupling_n_per_m > 0.0 ? Json(scene.contact.coupling_n_per_m)
                                                                           : Json("none"));
    options.set("device.handedness", scene.device_map.left_handed ? "left" : "right");
    options.set("device.force_return", scene.device.limits.ramp_s > 0.0 ? "ramp" : "leaving");
    if (scene.tool && !scene.tool->point_m.empty()) options.set("tool.points", scene.tool->point_m);
    Json material = options.has("material") ? options.at("material") : Json::object();
    store(scene.material, material);
    options.set("material", std::move(material));
    Json regions = Json::array(), terms = Json::array();
    for (const Region& region : scene.regions) {
        const bool is_known = options.has("region") && regions.size() < options.at("region").size();
        Json values = is_known ? options.at("region").at(regions.size()) : Json::object();
        store(region.material, values);
        regions.push_back(std::move(values));
    }
    if (!regions.empty()) options.set("region", std::move(regions));
    for (const RelaxationTerm& term : scene.relaxation) terms.push_back({{"share", term.share}, {"time", term.time_s}});
    if (!terms.empty()) options.set("relaxation", std::move(terms));
    return options;
}

Scene read_scene(const fs::path& file) {
    const toml::table table = parse_scene_file(file);
    const Section root(file, "", table);
    Scene scene;
    scene.file = file;
    scene.options = read_options(root);
    const SceneOptions& options = scene.options;
    check_name(root, options.text("name"));
    scene.device = device_of(*find_device_model(options.text("device.model")));
    begin_body(root, options, scene);
    scene.tool = begin_tool(root, options);
    visit_members(scene, Load{options});
    if (options.has("mesh.file")) scene.mesh.file = file.parent_path() / options.text("mesh.file");
    scene.material = read_material(root.section("material", true), scene.mesh.element);
    scene.regions = read_regions(root, options, scene.mesh.element);
    collect_directions(scene);
    scene.fixed = read_selections(root, options, "fixed");
    scene.membranes = read_membranes(root, options);
    scene.beds = read_beds(root, options);
    scene.gravity = read_gravity(options);
    scene.relaxation = read_relaxation(root, options);
    scene.touch = read_selections(root, options, "touch");
    if (scene.free_body && scene.free_body->floor) finish_floor(options, scene.gravity, *scene.free_body->floor);
    scene.contact.auto_coupling = options.at("contact.coupling") == "auto";
    if (!options.is_text("contact.coupling")) scene.contact.coupling_n_per_m = options.number("contact.coupling");
    if (scene.contact.kinetic_friction > scene.contact.static_friction)
        root.section("contact", false)
            .fail("kinetic_friction", fmt::format("is {} and must not be greater than friction, {}",
                                                  scene.contact.kinetic_friction, scene.contact.static_friction));
    scene.device_map.left_handed = options.text("device.handedness") == "left";
    scene.device.limits.grab = scene.contact.grab;
    if (const std::string fault = fault_of_mean(scene.device.limits, scene.device.max_force_n); !fault.empty())
        root.section("device", false).fail("mean_force_time", fault);
    if (scene.tool) finish_tool(root, file, options, *scene.tool);
    return scene;
}

}  // namespace haptable
