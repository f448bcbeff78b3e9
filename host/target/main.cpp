// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-count: how many instructions a tick takes on each target, by what it does; or those of every tick, with its
// bound; or what a scene's servo takes of a microcontroller: as JSON, of which lab/programs.py and lab/target.py make
// tables.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "codegen/loaded_scene.hpp"
#include "firmware/haptable_model.h"
#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/target/counts.hpp"
#include "host/target/linked.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kStrokes = 250;  // 10,000 ticks

struct Options {
    std::vector<fs::path> folders;
    fs::path build = "build";
    std::vector<std::string> targets{kTargets.begin(), kTargets.end()};
    std::string path;
    int strokes = 200, trace = -1;
    bool every_mode = false, two = false, link = false;
};

TargetImage image_of(const fs::path& build, const std::string& scene, const std::string& target) {
    TargetImage image(build, scene, target);
    if (const std::string missing = image.missing(); !missing.empty()) throw Error(missing);
    return image;
}

TargetImage own_image(const fs::path& folder, const std::string& target) {
    return image_of(folder.parent_path(), folder.filename(), target);
}

// ---- by what a tick does --------------------------------------------------------------------------------------------

ordered_json to_json(const TickCounts& counts) {
    ordered_json json;
    for (const auto& [kind, of] : {std::pair{"sliding", counts.sliding},
                                   {"first_contact", counts.first_contact},
                                   {"free", counts.free},
                                   {"leaving", counts.leaving},
                                   {"jump", counts.jump}})
        json[kind] = {{"median", of.median}, {"p999", of.p999}, {"worst", of.worst}};
    return json;
}

/// What `with` tells of the path of a scene's one finger or two, which jumps from stroke to stroke.
template <typename With>
ordered_json on_jumping_path(const LoadedScene& scene, const With& with) {
    const ServoPair* coupling = scene.coupling();
    if (scene.tool() != nullptr || (coupling != nullptr && coupling->finger_count > HAPTABLE_FINGERS))
        throw Error(scene.folder().text() + ": its scene has a tool, or three fingers and more: give --path strokes");
    const auto stroke_m = stroke_path(scene.tables(), kStrokes);
    return coupling != nullptr ? with(of_two(stroke_m, kStrokes)) : with(stroke_m);
}

/// What one scene's ticks take on every target: with its limits, by its own image; without, along a path that jumps;
/// and which of the sliding ones are the median and the worst.
ordered_json counts_of(const fs::path& folder) {
    const LoadedScene scene(read_unlimited(folder));
    const TargetScene measured{scene.model(), scene.pair(), scene.body(), scene.servo_modes()};
    return on_jumping_path(scene, [&](const auto& jumping_m) {
        ordered_json json{{"name", scene.tables().name}};
        for (const char* target : kTargets) {
            const auto path_m = walked(jumping_m);
            const TargetImage image = own_image(folder, target), measuring(folder.parent_path(), "cube", target);
            const TickCounts limited = count_ticks(path_m, image.replay(path_m));
            json["targets"][target] = {
                {"limited", to_json(limited)},
                {"unlimited", to_json(count_ticks(jumping_m, measuring.measure(measured, jumping_m)))},
                {"sliding_at", limited.sliding_at}};
        }
        return json;
    });
}

/// The addresses of the instructions of a tick of that path, with its limits.
ordered_json trace(const Options& o) {
    const TargetImage image = own_image(o.folders.front(), o.targets.front());
    return on_jumping_path(LoadedScene(TablesFolder(o.folders.front())), [&](const auto& jumping_m) -> ordered_json {
        return image.trace(walked(jumping_m), static_cast<std::size_t>(o.trace));
    });
}

// ---- every tick -----------------------------------------------------------------------------------------------------

ordered_json to_json(const std::vector<TargetTick>& ticks, std::size_t fingers) {
    ordered_json instructions = ordered_json::array(), states = ordered_json::array();
    for (const TargetTick& tick : ticks) {
        instructions.push_back(tick.instructions);
        ordered_json& state = states.emplace_back(ordered_json::array());
        for (std::size_t f = 0; f < fingers; ++f) state.push_back(tick.finger[f].state);
    }
    return {{"instructions", instructions}, {"states", states}};
}

/// What the scene's contact chooses.
Mode own_mode(const Tables& tables) {
    return {tables.force, tables.god_object, tables.static_friction > 0.0 ? "friction" : ""};
}

/// The scene as one finger, two or its tool meet it on strokes, by the image that reads any scene.
ordered_json count_strokes(const Options& o) {
    const LoadedScene scene(read_unlimited(o.folders.front()));
    const Tables& tables = scene.tables();
    const std::uint64_t fan = most_patches_around_a_vertex(scene.model());
    const auto path_m =
        o.path == "hard" && scene.tool() == nullptr ? hard_path(tables, o.strokes) : stroke_path(tables, o.strokes);
    ordered_json counted = ordered_json::array();
    for (const Mode& mode : o.every_mode ? every_mode() : std::vector{own_mode(tables)}) {
        const bool is_of_tool = mode.more.empty() || mode.more == "friction";  // or it has no part for it
        if (mode.force != tables.force || (scene.tool() != nullptr && !is_of_tool)) continue;
        const haptable_model model = o.every_mode ? in_mode(scene.model(), mode) : scene.model();
        if (o.two && scene.servo_pair() == nullptr)
            throw Error(o.folders.front().string() + ": its scene has one finger");
        haptable_pair_model pair;
        if (o.two || scene.tool() != nullptr) pair = pair_in_memory(*scene.coupling(), tables, model);
        for (const std::string& target : o.targets) {
            const TargetImage image = image_of(o.build, "cube", target);
            ordered_json& one =
                counted.emplace_back(ordered_json{{"mode", mode.name()}, {"target", target}, {"fan", fan}});
            if (scene.tool() != nullptr) {
                const haptable_tool_model tool = tool_in_memory(*scene.tool_tables(), scene.tool_points(), pair);
                one["bound"] = most_tool_cost(mode, fan, tool.points.count);
                one.update(to_json(image.measure({.model = model, .tool = &tool}, poses_of(path_m)), 1));
            } else if (o.two) {
                one["bound"] = most_pair_cost(mode, fan);
                one.update(to_json(image.measure({model, &pair}, of_two(hard_path(tables, o.strokes), o.strokes)), 2));
            } else {
                one["bound"] = most_cost(mode, fan);
                one.update(to_json(image.measure({model}, path_m), 1));
            }
        }
    }
    return counted;
}

/// The ticks of a session on the scene's own image, and the most that one of them can cost, with all that moves.
template <std::size_t size>
ordered_json replay(const Options& o, const TargetPath<size>& path_m) {
    const LoadedScene scene{TablesFolder(o.folders.front())};
    const Mode mode = own_mode(scene.tables());
    const std::uint64_t fan = most_patches_around_a_vertex(scene.model());
    const std::uint64_t bound = scene.tool() != nullptr   ? most_tool_cost(mode, fan, scene.tool()->points.count)
                                : scene.pair() != nullptr ? most_moving_cost(scene, mode) + most_pair_cost(mode, fan)
                                                          : most_moving_cost(scene, mode) + most_cost(mode, fan);
    ordered_json counted = ordered_json::array();
    for (const std::string& target : o.targets) {
        const TargetImage image = own_image(o.folders.front(), target);
        ordered_json& one = counted.emplace_back(ordered_json{{"target", target}, {"bound", bound}});
        if (scene.body_modes() != nullptr) one["modes"] = scene.body_modes()->modes();
        one.update(to_json(image.replay(path_m), scene.tool() != nullptr ? 1 : size / 3));
    }
    return counted;
}

ordered_json count(const Options& o) {
    if (o.trace >= 0) return trace(o);
    if (o.path.empty()) {
        ordered_json all = ordered_json::array();
        for (const fs::path& folder : o.folders) all.push_back(counts_of(folder));
        return all;
    }
    if (o.path == "tip") return replay(o, tip_path());
    if (o.path == "grasp") return replay(o, grasp_path());
    if (o.path == "knock") return replay(o, knock_path());
    if (o.path == "squeeze") return replay(o, squeeze_path());
    if (o.path == "turn") return replay(o, poses_of(walked(stroke_path(read_tables(o.folders.front()), o.strokes))));
    if (o.path != "hard" && o.path != "strokes")
        throw Error(o.path + ": is no path: hard, strokes, tip, grasp, knock, squeeze, turn");
    return count_strokes(o);
}

/// Bytes of the servo that is linked with what the scene's tables name.
ordered_json link(const Options& o) {
    const LinkedServo linked = link_servo(o.folders.front(), o.build / "cube/firmware/cortex-m7");
    return {{"flash", linked.flash}, {"ram", linked.ram}};
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Counts the instructions of a servo's tick on emulated microcontrollers.", "haptable-count");
    Options o;
    app.option("DIR", o.folders, "folders of scenes: build/cube build/mouse; of one with --path, --trace or --link")
        .required();
    app.option("--path", o.path,
               "every tick on hard, strokes; or a session of the scene's own image: tip, grasp, knock, squeeze, of a "
               "tool turn");
    app.option("--build", o.build, "where the cube's images are").show_default();
    app.option("--target", o.targets, "of these").delimiter(',').show_default();
    app.option("--strokes", o.strokes, "of a path").range(1, 1000000).show_default();
    app.option("--trace", o.trace, "addresses of the instructions of that tick, on the first target");
    app.flag("--every-mode", o.every_mode, "in every mode of the tables' force");
    app.flag("--two", o.two, "two fingers, on paths of their own");
    app.flag("--link", o.link, "the servo's bytes on a Cortex-M7 instead");
    return run_program(app, argc, argv, [&] {
        if ((o.link || o.trace >= 0 || !o.path.empty()) && o.folders.size() > 1)
            throw Error("DIR: give one folder with --path, --trace or --link");
        fmt::print("{}\n", (o.link ? link(o) : count(o)).dump());
    });
}
