// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-count: how many instructions a tick takes on each target.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/target/counts.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

constexpr int kStrokes = 250;                        // 10,000 ticks
constexpr double kInstructionsAMillisecond = 168e3;  // 168 MHz, one instruction a clock

void print_row(const std::string& scene, const std::string& target, const char* kind, const Counts& counts) {
    fmt::print("| {} | {} | {} | {} | {} | {} | {} | {:.1f} % |\n", scene, target, kind, counts.ticks, counts.median,
               counts.p999, counts.worst, 100.0 * static_cast<double>(counts.worst) / kInstructionsAMillisecond);
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
        const TickCounts counts = count_ticks(path_m, image.replay(path_m));
        print_row(tables.name, target, "free", counts.free);
        print_row(tables.name, target, "first contact", counts.first_contact);
        print_row(tables.name, target, "sliding", counts.sliding);
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
