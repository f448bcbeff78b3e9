// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-count: how many instructions a tick takes on each target.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "firmware/haptable.h"
#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/target/counts.hpp"
#include "host/target/cycles.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

constexpr int kStrokes = 250;                        // 10,000 ticks
constexpr double kInstructionsAMillisecond = 168e3;  // 168 MHz, one instruction a clock

void print_row(const std::string& scene, const std::string& target, const char* kind, const Counts& counts) {
    fmt::print("| {} | {} | {} | {} | {} | {} | {} | {:.1f} % |\n", scene, target, kind, counts.ticks, counts.median,
               counts.p999, counts.worst, 100.0 * static_cast<double>(counts.worst) / kInstructionsAMillisecond);
}

/// The sliding ticks with the median and the greatest count.
std::pair<std::size_t, std::size_t> median_and_worst(const std::vector<TargetTick>& ticks, const Counts& sliding) {
    std::size_t median = 0, worst = 0;
    for (std::size_t i = 1; i < ticks.size(); ++i) {
        if (ticks[i].state != HAPTABLE_CONTACT || ticks[i - 1].state != HAPTABLE_CONTACT) continue;
        if (ticks[i].instructions == sliding.median) median = i;
        if (ticks[i].instructions == sliding.worst) worst = i;
    }
    return {median, worst};
}

/// As a row of the same table: what the sliding ticks would take in cycles, by LLVM's model.
void print_estimate(const std::string& scene, const TargetImage& image, const std::vector<std::array<float, 3>>& path_m,
                    const std::vector<TargetTick>& ticks, const Counts& sliding) {
    const auto [median, worst] = median_and_worst(ticks, sliding);
    const auto cycles = estimate_cycles(image, path_m, median), most = estimate_cycles(image, path_m, worst);
    if (!cycles || !most) return;
    fmt::print("| {} | {} | sliding, estimated cycles (llvm-mca) | | {} | | {} | {:.1f} % |\n", scene, image.target(),
               *cycles, *most, 100.0 * static_cast<double>(*most) / kInstructionsAMillisecond);
}

void count_scene(const std::filesystem::path& folder) {
    const Tables tables = read_tables(folder);
    for (const char* target : kTargets) {
        const TargetImage image(folder.parent_path(), folder.filename(), target);
        if (const std::string missing = image.missing(); !missing.empty()) {
            fmt::print(stderr, "haptable-count: {}\n", missing);
            continue;
        }
        const auto path_m = stroke_path(tables, kStrokes);
        const std::vector<TargetTick> ticks = image.replay(path_m);
        const TickCounts counts = count_ticks(path_m, ticks);
        print_row(tables.name, target, "free", counts.free);
        print_row(tables.name, target, "first contact", counts.first_contact);
        print_row(tables.name, target, "sliding", counts.sliding);
        print_estimate(tables.name, image, path_m, ticks, counts.sliding);
        print_row(tables.name, target, "leaving", counts.leaving);
        print_row(tables.name, target, "jump", counts.jump);
    }
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    CLI::App app("Counts the instructions of a servo's tick on emulated microcontrollers.", "haptable-count");
    std::vector<std::string> folders;
    app.add_option("DIR", folders, "folders of scenes: build/cube build/mouse")->required();
    return haptable::run_program(app, argc, argv, [&] {
        fmt::print("| scene | target | tick | ticks | median | 99.9 % | worst | worst, of 1 ms at 168 MHz |\n");
        fmt::print("|---|---|---|---|---|---|---|---|\n");
        for (const std::string& folder : folders) haptable::count_scene(folder);
    });
}
