// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-count: how many instructions a tick takes on each target.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "codegen/loaded_scene.hpp"
#include "firmware/haptable_model.h"
#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/numbers/numbers.hpp"
#include "host/target/counts.hpp"
#include "host/target/cycles.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

constexpr int kStrokes = 250;                        // 10,000 ticks
constexpr double kInstructionsAMillisecond = 168e3;  // 168 MHz, one instruction a clock

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

/// "median / 99.9 % / worst"
Number cell(const Counts& counts) {
    return {{static_cast<double>(counts.median), static_cast<double>(counts.p999), static_cast<double>(counts.worst)},
            fmt::format("{} / {} / {}", thousands(counts.median), thousands(counts.p999), thousands(counts.worst))};
}

Number of_a_millisecond(std::uint64_t instructions) {
    const double fraction = static_cast<double>(instructions) / kInstructionsAMillisecond;
    return number(fraction, fmt::format("{:.1f} %", 100.0 * fraction));
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

/// What one scene's ticks take on every target, of fingers that have `size` coordinates.
template <std::size_t size>
class SceneCounts {
public:
    explicit SceneCounts(const std::filesystem::path& folder)
        : tables_(read_tables(folder)), path_m_(walked(strokes_of<size>(tables_))) {
        const LoadedScene scene(unlimited(folder));
        const auto jumping_m = strokes_of<size>(tables_);
        for (const char* target : kTargets) {
            const TargetImage image(folder.parent_path(), folder.filename(), target);
            const TargetImage measuring(folder.parent_path(), "cube", target);
            if (const std::string missing = image.missing(); !missing.empty()) throw Error(missing);
            ticks_.push_back(image.replay(path_m_));
            limited_.push_back(count_ticks(path_m_, ticks_.back()));
            counts_.push_back(count_ticks(jumping_m, measuring.measure(measured(scene), jumping_m)));
            image_.push_back(image);
        }
    }

    void add_counts(NumberTable& table) const {
        const std::pair<const char*, Counts TickCounts::*> kinds[] = {{"sliding", &TickCounts::sliding},
                                                                      {"first contact", &TickCounts::first_contact},
                                                                      {"free", &TickCounts::free},
                                                                      {"leaving", &TickCounts::leaving},
                                                                      {"a jump", &TickCounts::jump}};
        for (const auto& [name, kind] : kinds) add_row(name, kind, counts_, table);
        add_row("sliding, with its limits", &TickCounts::sliding, limited_, table);
        add_row("free, with its limits", &TickCounts::free, limited_, table);
    }

    /// What the sliding ticks would take in cycles, by LLVM's model; no rows where it has none.
    void add_estimates(NumberTable& table) const {
        for (std::size_t k = 0; k < image_.size(); ++k) {
            const auto [median, worst] = median_and_worst(ticks_[k], size / 3, limited_[k].sliding);
            const auto cycles = estimate_cycles(image_[k], path_m_, median);
            const auto most = estimate_cycles(image_[k], path_m_, worst);
            if (cycles && most)
                table.rows.push_back(
                    {fmt::format("{}, {}", tables_.name, image_[k].target()), count(*cycles), count(*most)});
        }
    }

private:
    void add_row(const char* name, Counts TickCounts::*kind, const std::vector<TickCounts>& of_targets,
                 NumberTable& table) const {
        auto& row = table.rows.emplace_back(std::vector<Cell>{fmt::format("{}, {}", tables_.name, name)});
        std::uint64_t worst = 0;
        for (const TickCounts& counts : of_targets) {
            row.push_back(cell(counts.*kind));
            worst = std::max(worst, (counts.*kind).worst);
        }
        row.push_back(of_a_millisecond(worst));
    }

    Tables tables_;
    TargetPath<size> path_m_;
    std::vector<TargetImage> image_;
    std::vector<std::vector<TargetTick>> ticks_;  // [targets], of the scene's image along path_m_
    std::vector<TickCounts> limited_;             // [targets], of these
    std::vector<TickCounts> counts_;              // [targets], without limits, along a path that jumps
};

template <std::size_t size>
void add(const std::string& folder, NumberTable& counted, NumberTable& estimated) {
    const SceneCounts<size> scene(folder);
    scene.add_counts(counted);
    scene.add_estimates(estimated);
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Counts the instructions of a servo's tick on emulated microcontrollers.", "haptable-count");
    std::vector<std::string> folders;
    std::filesystem::path out;
    app.option("DIR", folders, "folders of scenes: build/cube build/mouse").required();
    app.option("-o", out, "write the numbers to this JSON file");
    return run_program(app, argc, argv, [&] {
        NumberTable counted{{"tick"}, {}}, estimated{{"sliding", "median", "worst"}, {}};
        for (const char* target : kTargets) counted.columns.emplace_back(target);
        counted.columns.emplace_back("worst, of 1 ms at 168 MHz");
        for (const std::string& folder : folders)
            read_pair(std::filesystem::path(folder)) ? add<6>(folder, counted, estimated)
                                                     : add<3>(folder, counted, estimated);
        Numbers numbers("make instructions");
        numbers.add("instructions", counted);
        if (!estimated.rows.empty()) numbers.add("cycles", estimated);
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
