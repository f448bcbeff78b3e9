// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-target: the instructions of every tick of a scene on the targets, its bound, and what its servo takes
// of a microcontroller: raw numbers as JSON, of which lab/target.py makes tables.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "codegen/loaded_scene.hpp"
#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/target/image.hpp"
#include "host/target/linked.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct Options {
    fs::path folder, build = "build";
    std::vector<std::string> targets{kTargets.begin(), kTargets.end()};
    std::string path = "hard";
    int strokes = 200;
    bool every_mode = false, two = false, link = false;
};

ordered_json to_json(const std::vector<TargetTick>& ticks, std::size_t fingers) {
    ordered_json instructions = ordered_json::array(), states = ordered_json::array();
    for (const TargetTick& tick : ticks) {
        instructions.push_back(tick.instructions);
        ordered_json& state = states.emplace_back(ordered_json::array());
        for (std::size_t f = 0; f < fingers; ++f) state.push_back(tick.finger[f].state);
    }
    return {{"instructions", instructions}, {"states", states}};
}

/// The scene without its limits: a finger jumps here.
SceneFiles unlimited(const fs::path& folder) {
    SceneFiles files = read_scene_files(TablesFolder(folder));
    files.tables.limits = {};
    return files;
}

/// What the scene's contact chooses.
Mode own_mode(const Tables& tables) {
    return {tables.force, tables.god_object, tables.static_friction > 0.0 ? "friction" : ""};
}

/// The scene as one finger or two meet it on strokes, by the image that reads any scene.
ordered_json count_strokes(const Options& o) {
    const LoadedScene scene(unlimited(o.folder));
    const Tables& tables = scene.tables();
    const std::uint64_t fan = most_patches_around_a_vertex(scene.model());
    ordered_json counted = ordered_json::array();
    for (const Mode& mode : o.every_mode ? every_mode() : std::vector{own_mode(tables)}) {
        if (mode.force != tables.force) continue;
        const haptable_model model = o.every_mode ? in_mode(scene.model(), mode) : scene.model();
        for (const std::string& target : o.targets) {
            const TargetImage image(o.build, "cube", target);
            if (const std::string missing = image.missing(); !missing.empty()) throw Error(missing);
            ordered_json& one =
                counted.emplace_back(ordered_json{{"mode", mode.name()}, {"target", target}, {"fan", fan}});
            if (o.two) {
                if (scene.servo_pair() == nullptr) throw Error(o.folder.string() + ": its scene has one finger");
                const haptable_pair_model pair = pair_in_memory(*scene.servo_pair(), tables, model);
                one["bound"] = most_pair_cost(mode, fan);
                one.update(to_json(image.measure({model, &pair}, hard_path_of_two(tables, o.strokes)), 2));
            } else {
                const auto path_m = o.path == "hard" ? hard_path(tables, o.strokes) : stroke_path(tables, o.strokes);
                one["bound"] = most_cost(mode, fan);
                one.update(to_json(image.measure({model}, path_m), 1));
            }
        }
    }
    return counted;
}

/// The most that a tick of the scene can cost, with all that moves.
std::uint64_t bound_of(const LoadedScene& scene) {
    const Mode mode = own_mode(scene.tables());
    const std::uint64_t fan = most_patches_around_a_vertex(scene.model());
    return most_moving_cost(scene, mode) + (scene.pair() != nullptr ? most_pair_cost(mode, fan) : most_cost(mode, fan));
}

template <std::size_t size>
ordered_json replay(const Options& o, const TargetPath<size>& path_m) {
    const LoadedScene scene{TablesFolder(o.folder)};
    ordered_json counted = ordered_json::array();
    for (const std::string& target : o.targets) {
        const TargetImage image(o.folder.parent_path(), o.folder.filename(), target);
        if (const std::string missing = image.missing(); !missing.empty()) throw Error(missing);
        ordered_json& one = counted.emplace_back(ordered_json{{"target", target}, {"bound", bound_of(scene)}});
        if (scene.body_modes() != nullptr) one["modes"] = scene.body_modes()->modes();
        one.update(to_json(image.replay(path_m), size / 3));
    }
    return counted;
}

ordered_json count(const Options& o) {
    if (o.path == "tip") return replay(o, tip_path());
    if (o.path == "grasp") return replay(o, grasp_path());
    if (o.path == "knock") return replay(o, knock_path());
    if (o.path == "squeeze") return replay(o, squeeze_path());
    if (o.path != "hard" && o.path != "strokes")
        throw Error(o.path + ": is no path: hard, strokes, tip, grasp, knock, squeeze");
    return count_strokes(o);
}

/// Bytes of the servo that is linked with what the scene's tables name.
ordered_json link(const Options& o) {
    const fs::path objects = o.build / "cube/firmware/cortex-m7";
    if (const std::string missing = missing_for_link(objects); !missing.empty()) throw Error(missing);
    const LinkedServo linked = link_servo(o.folder, objects);
    return {{"flash", linked.flash}, {"ram", linked.ram}, {"stack", stack_of(o.folder, objects)}};
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Counts the instructions of every tick of a scene on emulated microcontrollers.",
                    "haptable-bench-target");
    Options o;
    app.option("DIR", o.folder, "a folder that haptable-precompute has made").required();
    app.option("--build", o.build, "where the cube's images are").show_default();
    app.option("--target", o.targets, "of these").delimiter(',').show_default();
    app.option("--path", o.path, "hard, strokes; or a session of the scene's own image: tip, grasp, knock, squeeze");
    app.option("--strokes", o.strokes, "of a path").range(1, 1000000).show_default();
    app.flag("--every-mode", o.every_mode, "in every mode of the tables' force");
    app.flag("--two", o.two, "two fingers, on paths of their own");
    app.flag("--link", o.link, "the servo's bytes on a Cortex-M7 instead");
    return run_program(app, argc, argv, [&] { fmt::print("{}\n", (o.link ? link(o) : count(o)).dump()); });
}
