// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-count: how many instructions a tick takes on each target, as JSON, of which lab/programs.py makes tables.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "codegen/loaded_scene.hpp"
#include "firmware/haptable_model.h"
#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/target/counts.hpp"
#include "host/target/cycles.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

using nlohmann::ordered_json;

constexpr int kStrokes = 250;  // 10,000 ticks

/// The sliding ticks with the median and the greatest count.
std::pair<std::size_t, std::size_t> median_and_worst(const std::vector<TargetTick>& ticks, std::size_t fingers,
                                                     const Counts& sliding) {
    std::size_t median = 0, worst = 0;
    for (std::size_t i = 1; i < ticks.size(); ++i) {
        if (!ticks[i].touches(fingers) || !ticks[i - 1].touches(fingers)) continue;
        if (ticks[i].instructions == sliding.median) median = i;
        if (ticks[i].instructions == sliding.worst) worst = i;
    }
    return {median, worst};
}

ordered_json to_json(const Counts& counts) {
    return {{"ticks", counts.ticks}, {"median", counts.median}, {"p999", counts.p999}, {"worst", counts.worst}};
}

ordered_json to_json(const TickCounts& counts) {
    return {{"sliding", to_json(counts.sliding)},
            {"first_contact", to_json(counts.first_contact)},
            {"free", to_json(counts.free)},
            {"leaving", to_json(counts.leaving)},
            {"jump", to_json(counts.jump)}};
}

/// Strokes of one finger; of two each has its own.
template <std::size_t size>
TargetPath<size> strokes_of(const Tables& tables);
template <>
TargetPath<3> strokes_of(const Tables& tables) {
    return stroke_path(tables, kStrokes);
}
template <>
TargetPath<6> strokes_of(const Tables& tables) {
    return of_two(stroke_path(tables, kStrokes), kStrokes);
}

/// The scene of a folder without the device's limits: the body's own force, at any jump.
SceneFiles unlimited(const TablesFolder& folder) {
    SceneFiles files = read_scene_files(folder);
    files.tables.limits = {};
    return files;
}

TargetScene measured(const LoadedScene& scene) {
    return {scene.model(), scene.pair(), scene.body(), scene.servo_modes()};
}

/// What one scene's ticks take on every target, of fingers that have `size` coordinates: with its limits, by its own
/// image; without, along a path that jumps; and the sliding ticks' cycles by LLVM's model, where it has one.
template <std::size_t size>
ordered_json counts_of(const std::filesystem::path& folder) {
    const Tables tables = read_tables(folder);
    const auto jumping_m = strokes_of<size>(tables), path_m = walked(jumping_m);
    const LoadedScene scene(unlimited(folder));
    ordered_json json{{"name", tables.name}};
    for (const char* target : kTargets) {
        const TargetImage image(folder.parent_path(), folder.filename(), target);
        const TargetImage measuring(folder.parent_path(), "cube", target);
        if (const std::string missing = image.missing(); !missing.empty()) throw Error(missing);
        const std::vector<TargetTick> ticks = image.replay(path_m);
        const TickCounts limited = count_ticks(path_m, ticks);
        ordered_json& of = json["targets"][target];
        of = {{"limited", to_json(limited)},
              {"unlimited", to_json(count_ticks(jumping_m, measuring.measure(measured(scene), jumping_m)))}};
        const auto [median, worst] = median_and_worst(ticks, size / 3, limited.sliding);
        const auto cycles = estimate_cycles(image, path_m, median), most = estimate_cycles(image, path_m, worst);
        if (cycles && most) of["cycles"] = {*cycles, *most};
    }
    return json;
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Counts the instructions of a servo's tick on emulated microcontrollers.", "haptable-count");
    std::vector<std::string> folders;
    app.option("DIR", folders, "folders of scenes: build/cube build/mouse").required();
    return run_program(app, argc, argv, [&] {
        nlohmann::ordered_json all = nlohmann::ordered_json::array();
        for (const std::filesystem::path folder : folders)
            all.push_back(read_pair(folder) ? counts_of<6>(folder) : counts_of<3>(folder));
        fmt::print("{}\n", all.dump());
    });
}
