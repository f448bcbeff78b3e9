// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/target/named.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "codegen/in_memory.hpp"
#include "firmware/haptable_model.h"
#include "host/base/error.hpp"
#include "host/precompute/precompute.hpp"
#include "host/target/image.hpp"
#include "host/target/linked.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr int kStrokes = 100;  // 4,000 ticks
constexpr const char* kTarget = "cortex-m7";

/// What a scene names beside mesh, material and what is held.
struct SceneVariant {
    std::string what;
    std::function<void(Scene&, const Body&)> name;
    bool has_compliance = false;  ///< whose precision is told
};

std::array<double, 6> around(const Eigen::Vector3d& x) {
    constexpr double e = 1e-9;
    return {x.x() - e, x.y() - e, x.z() - e, x.x() + e, x.y() + e, x.z() + e};
}

/// Only the patch in the middle of the list: its nodes are the region.
void touch_one_patch(Scene& scene, const Body& body) {
    for (std::int32_t node : body.touch_patch[body.touch_patch.size() / 2])
        scene.touch.push_back({around(body.mesh.position_m[static_cast<std::size_t>(node)]), "", 1});
}

std::function<void(Scene&, const Body&)> with(const std::function<void(Scene&)>& change) {
    return [change](Scene& scene, const Body& /*body*/) { change(scene); };
}

std::function<void(Scene&, const Body&)> display(std::size_t rows) {
    return [rows](Scene& scene, const Body& body) {
        scene.tables.columns = ColumnRows::kSurface;
        for (std::size_t i = 0; i < std::min(rows, body.touch_node.size()); ++i)
            scene.tables.display_rows.push_back(body.touch_node[i * body.touch_node.size() / rows]);
    };
}

std::vector<SceneVariant> all_named(double mask_radius_m) {
    return {
        {"the paper's force, the whole surface", with([](Scene&) {})},
        {"one patch touched", touch_one_patch},
        {"`precision = \"float16\"`", with([](Scene& s) { s.tables.precision = Storage::kFloat16; })},
        {"`precision = \"int16\"`", with([](Scene& s) { s.tables.precision = Storage::kInt16; })},
        {"`force = \"consistent\"`", with([](Scene& s) { s.contact.force = ForceLaw::kConsistent; }), true},
        {"`force = \"pressure-mask\"`", with([=](Scene& s) {
             s.contact.force = ForceLaw::kPressureMask;
             s.contact.mask_radius_m = mask_radius_m;
         }),
         true},
        {"`force = \"pressure-mask\"`, `precision = \"float16\"`", with([=](Scene& s) {
             s.contact.force = ForceLaw::kPressureMask;
             s.contact.mask_radius_m = mask_radius_m;
             s.tables.precision = Storage::kFloat16;
         })},
        {"`god_object = \"least-energy\"`", with([](Scene& s) { s.contact.god_object = GodObject::kLeastEnergy; })},
        {"`friction = 0.5`", with([](Scene& s) { s.contact.static_friction = s.contact.kinetic_friction = 0.5; })},
        {"`release_slew = 0.01`", with([](Scene& s) { s.contact.release_n_per_ms = 0.01; })},
        {"`passivity = true`", with([](Scene& s) { s.contact.passivity = true; })},
        {"`coupling = \"auto\"`", with([](Scene& s) { s.contact.auto_coupling = true; })},
        {"`element = \"average-nodal-pressure\"`",
         with([](Scene& s) { s.mesh.element = Element::kAverageNodalPressure; })},
        {"10 `display_rows`", display(10)},
        {"mask, least energy, friction, release, passivity", with([=](Scene& s) {
             s.contact.force = ForceLaw::kPressureMask;
             s.contact.mask_radius_m = mask_radius_m;
             s.contact.god_object = GodObject::kLeastEnergy;
             s.contact.static_friction = s.contact.kinetic_friction = 0.5;
             s.contact.release_n_per_ms = 0.01;
             s.contact.passivity = true;
         })},
    };
}

/// What costs the same whatever the mesh.
std::vector<SceneVariant> named_of_any_mesh() {
    return {
        {"`[[relaxation]]`, one term", with([](Scene& s) {
             s.relaxation = {{0.3, 0.5}};
         })},
        {"`[[relaxation]]`, two terms", with([](Scene& s) {
             s.relaxation = {{0.3, 0.5}, {0.2, 10.0}};
         })},
        {"`[[relaxation]]`, one term, friction", with([](Scene& s) {
             s.relaxation = {{0.3, 0.5}};
             s.contact.static_friction = s.contact.kinetic_friction = 0.5;
         })},
        {"`grab = true`", with([](Scene& s) { s.contact.grab = true; })},
        {"`force_return = \"ramp\"`", with([](Scene& s) { s.device.limits.ramp_s = 1.0; })},
        {"`max_speed = \"off\"`", with([](Scene& s) { s.device.limits.max_speed_m_s = 0.0; })},
        {"`max_force_rate = \"off\"`", with([](Scene& s) { s.device.limits.max_force_rate_n_per_s = 0.0; })},
        {"`mean_force = \"off\"`", with([](Scene& s) { s.device.limits.mean_force_n = 0.0; })},
        {"`check = false`", with([](Scene& s) { s.device.limits.check = false; })},
        {"none of the limits, and no check", with([](Scene& s) { s.device.limits = {}; })},
    };
}

/// The median and the greatest of the ticks in contact.
Number instructions(const TargetImage& image, const haptable_model& model, const Tables& tables) {
    std::vector<std::uint64_t> counts;
    for (const TargetTick& tick : image.measure({model}, stroke_path(tables, kStrokes)))
        if (tick.touches()) counts.push_back(tick.instructions);
    if (counts.empty()) throw Error("the bench's finger touched nothing: no instructions were counted");
    std::sort(counts.begin(), counts.end());
    const std::uint64_t median = counts[counts.size() / 2], worst = counts.back();
    return {{static_cast<double>(median), static_cast<double>(worst)},
            fmt::format("{} / {}", thousands(median), thousands(worst))};
}

std::vector<Cell> precision_row(const std::string& name, const std::vector<PrecisionError>& all) {
    std::vector<Cell> row{name};
    for (const PrecisionError& error : all)
        row.push_back(Number{{static_cast<double>(error.bytes), error.worst},
                             fmt::format("{}, {:.1e}", thousands(error.bytes), error.worst)});
    return row;
}

void add_costs(const std::string& body, Scene scene, const SceneVariant& named, const fs::path& build,
               NamedCosts& costs) {
    const fs::path objects = build / "cube/firmware" / kTarget;
    scene.tables.columns = ColumnRows::kNone;
    scene.contact = {};
    scene.tables.precision = Storage::kFloat32;
    named.name(scene, make_body(scene, make_mesh(scene.mesh)));
    Progress progress(true);
    PrecomputeOptions options;
    options.force = true;
    options.threads = 1;
    const fs::path folder = build / "named" / scene.name;
    const Result result = precompute(scene, folder, progress, options);
    const auto& stages = result.summary.stages;
    const double cpu_s = std::accumulate(stages.begin(), stages.end(), 0.0,
                                         [](double sum, const StageCost& stage) { return sum + stage.cpu_s; });
    std::size_t table_bytes = 0;
    for (const TableBytes& table : result.summary.size.flash) table_bytes += table.bytes;
    const LinkedServo linked = link_servo(folder, objects);
    Tables tables = read_tables(folder);
    tables.limits = {};  // a finger jumps here
    const ServoModel servo = build_model(tables);
    if (named.has_compliance)
        costs.precision.rows.push_back(precision_row(body + ": " + named.what, result.summary.size.precision));
    (body == "cube" ? costs.costs : costs.mouse)
        .rows.push_back({body + ": " + named.what, count(table_bytes), count(linked.flash - table_bytes),
                         count(linked.ram), count(stack_of(folder, objects)),
                         instructions(TargetImage(build, "cube", kTarget), model_in_memory(tables, servo), tables),
                         seconds(cpu_s)});
}

}  // namespace

NamedCosts named_costs(const fs::path& build) {
    const std::string missing = missing_for_link(build / "cube/firmware" / kTarget);
    if (!missing.empty()) throw Error(missing);
    const NumberTable none{{"the scene names", "tables, bytes", "code, bytes", "RAM, bytes", "stack, bytes",
                            "instructions a tick in contact, median / worst", "precompute"},
                           {}};
    NamedCosts costs{none, none, {{"the scene names", "float32", "float16", "int16"}, {}}};
    for (const auto& [body, scene, radius_m] :
         {std::tuple{"cube", "meshes/cube.toml", 0.012}, {"mouse", "meshes/mouse.toml", 0.006}})
        for (const SceneVariant& named : all_named(radius_m)) add_costs(body, read_scene(scene), named, build, costs);
    for (const SceneVariant& named : named_of_any_mesh())
        add_costs("cube", read_scene("meshes/cube.toml"), named, build, costs);
    return costs;
}

}  // namespace haptable
