// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench: speed against error of the servo, of equation 8 and of the drawing, beside the paper's Table 2.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

extern "C" {
#include "firmware/haptable_patch.h"
}
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/bench/report.hpp"
#include "host/bench/solver.hpp"
#include "host/bench/subject.hpp"
#include "host/view/painter.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

constexpr std::size_t kTicks = 1000;       // of a path: 100 mm/s round a circle of 16 mm
constexpr double kDepth = 0.002;           // m, under the surface
constexpr std::size_t kErrorPatches = 50;  // patches on which equation 8 is compared with a solve

/// A scene of the bench with everything that is measured on it.
struct Case {
    Case(const fs::path& scene, const fs::path& folder)
        : subject(folder),
          name(subject.tables().name),
          solver(scene),
          deformation(subject.tables(), folder),
          painter(subject.tables(), folder, ViewOptions{}, true),
          sliding(subject.circle(kDepth, kTicks)),
          hovering(subject.circle(-kDepth, kTicks)),
          loads(three_loads(subject.tables(), subject.tables().patch.size() / 2)) {}

    Subject subject;
    std::string name;
    Solver solver;
    Deformation deformation;
    Painter painter;
    FingerPath sliding;
    FingerPath hovering;
    std::vector<NodalForce> loads;
};

/// Steps along a path, over and over.
void step_along(benchmark::State& state, const Subject& subject, const FingerPath& path) {
    haptable_servo servo = subject.touched(path);
    haptable_output out{};
    std::size_t tick = 0;
    for (auto _ : state) {
        haptable_step(&subject.model(), &servo, path[tick].data(), 0, &out);
        benchmark::DoNotOptimize(out);
        tick = tick + 1 == path.size() ? 0 : tick + 1;
    }
}

void force_step(benchmark::State& state, Case& with) { step_along(state, with.subject, with.sliding); }

void free_step(benchmark::State& state, Case& with) { step_along(state, with.subject, with.hovering); }

/// What the walk saves: the nearest point of every patch, every tick.
void search_all(benchmark::State& state, Case& with) {
    const haptable_model& model = with.subject.model();
    std::size_t tick = 0;
    for (auto _ : state) {
        for (std::uint16_t patch = 0; patch < model.patch_count; ++patch) {
            haptable_contact nearest;
            haptable_patch_nearest(&model, patch, with.sliding[tick].data(), &nearest);
            benchmark::DoNotOptimize(nearest);
        }
        tick = tick + 1 == with.sliding.size() ? 0 : tick + 1;
    }
}

void equation_8(benchmark::State& state, Case& with) {
    for (auto _ : state) benchmark::DoNotOptimize(with.deformation.displace(with.loads).data());
}

void one_solve(benchmark::State& state, Case& with) {
    for (auto _ : state) benchmark::DoNotOptimize(with.solver.solve(with.loads).data());
}

ContactFrame pressed_frame(const Case& with) {
    ContactFrame frame;
    frame.finger_known = true;
    frame.contact = true;
    const auto& finger = with.sliding.front();
    frame.finger_m = {static_cast<double>(finger[0]), static_cast<double>(finger[1]), static_cast<double>(finger[2])};
    frame.god_object_m = frame.finger_m + Eigen::Vector3d(0.0, 0.0, kDepth);
    frame.force_n = {0.0, 0.0, 0.5};
    frame.loads = with.loads;
    return frame;
}

/// Deformation, upload, rendering and text of one picture; the PNG apart.
void draw(benchmark::State& state, Case& with) {
    const ContactFrame frame = pressed_frame(with);
    Ranges ranges;
    with.painter.measure(frame, ranges);
    for (auto _ : state) benchmark::DoNotOptimize(&with.painter.paint(frame, ranges));
}

struct Measurement {
    const char* row;
    void (*run)(benchmark::State&, Case&);
};

constexpr std::array kMeasurements = {
    Measurement{"force step, sliding", force_step},
    Measurement{"force step, free", free_step},
    Measurement{"search over all patches", search_all},
    Measurement{"equation 8", equation_8},
    Measurement{"one solve", one_solve},
    Measurement{"draw", draw},
};

/// Collects the runs' times and stays silent.
class Collector : public benchmark::BenchmarkReporter {
public:
    explicit Collector(Timings& timings) : timings_(timings) {}
    bool ReportContext(const Context&) override { return true; }
    void ReportRuns(const std::vector<Run>& runs) override {
        for (const Run& run : runs) {
            if (run.run_type != Run::RT_Iteration) continue;
            const std::string name = run.run_name.function_name;
            const auto colon = name.find(':');
            timings_.add(name.substr(colon + 1), name.substr(0, colon), run.GetAdjustedCPUTime());
        }
    }

private:
    Timings& timings_;
};

Timings measure(std::vector<std::unique_ptr<Case>>& cases, int repetitions, double seconds) {
    for (const Measurement& measurement : kMeasurements)
        for (const auto& with : cases)
            benchmark::RegisterBenchmark(
                (with->name + ":" + measurement.row).c_str(),
                [&measurement, &with](benchmark::State& state) { measurement.run(state, *with); })
                ->Repetitions(repetitions)
                ->MinTime(seconds);
    // Repetitions of all in turn, so that a ratio compares the same minutes of a busy machine.
    std::string program = "haptable-bench", interleave = "--benchmark_enable_random_interleaving=true";
    std::array<char*, 2> arguments{program.data(), interleave.data()};
    int count = 2;
    benchmark::Initialize(&count, arguments.data());
    Timings timings;
    Collector collector(timings);
    benchmark::RunSpecifiedBenchmarks(&collector);
    return timings;
}

ReportRow speed_row(const std::string& what, const std::string& row, const Timings& timings,
                    const std::vector<std::string>& names, const std::string& beside) {
    ReportRow line{what, {}, beside};
    for (const std::string& name : names) line.cells.push_back(duration(timings.at(row, name)));
    return line;
}

ReportRow ratio_row(const std::string& what, double ratio, bool kept, const std::string& wanted) {
    return {what, {fmt::format("{:.3g}", ratio)}, wanted + (kept ? ": kept" : ": MISSED")};
}

Report make_report(const Timings& timings, std::vector<std::unique_ptr<Case>>& cases) {
    Report report;
    for (const auto& with : cases) report.subjects.push_back(with->name);
    const auto& names = report.subjects;
    report.speed = {
        speed_row("force: god-object and equations 9 to 12, sliding at 100 mm/s", "force step, sliding", timings, names,
                  "15 us cube, 12 us mouse"),
        speed_row("the same tick with the finger 2 mm above the surface", "force step, free", timings, names, ""),
        speed_row("for comparison: nearest point of every patch", "search over all patches", timings, names, ""),
        speed_row("displacement: equation 8, three nodes, free surface", "equation 8", timings, names,
                  "158 us cube, 4181 us mouse"),
        speed_row("for comparison: one solve with a kept CHOLMOD factor", "one solve", timings, names, ""),
        speed_row("one picture, 960 x 720, without PNG", "draw", timings, names, "97 Hz cube, 2 Hz mouse"),
    };
    ReportRow force{"force in float32, sliding 2 mm deep, worst", {}, "equations 9 to 12 in double"};
    ReportRow moved{"displacement, float32 columns, worst", {}, "a solve in double"};
    ReportRow bytes{"servo's tables in flash", {}, "bytes"};
    for (const auto& with : cases) {
        force.cells.push_back(fmt::format("{:.1e}", force_error(with->subject, with->sliding)));
        moved.cells.push_back(fmt::format(
            "{:.1e}", displacement_error(with->deformation, with->solver, with->subject.tables(), kErrorPatches)));
        bytes.cells.push_back(fmt::format("{}", with->subject.table_bytes()));
    }
    report.error = {force, moved, bytes};
    for (std::size_t k = 0; k < 3; ++k) {
        ReportRow row;
        for (const auto& with : cases) {
            const PrecisionError error = with->subject.precisions()[k];
            row.what =
                fmt::format("force with blocks in {}: bytes, worst over patches and directions", error.precision);
            row.cells.push_back(fmt::format("{}, {:.1e}", error.bytes, error.worst));
        }
        row.beside = "the blocks in double";
        report.error.push_back(row);
    }
    for (const std::string& name : names) {
        const double solve = timings.at("one solve", name) / timings.at("force step, sliding", name);
        report.ratio.push_back(ratio_row(name + ": one solve over a force step", solve, solve >= 30.0, "at least 30"));
    }
    if (names.size() == 2) {
        const double step = timings.at("force step, sliding", names[1]) / timings.at("force step, sliding", names[0]);
        report.ratio.push_back(
            ratio_row(fmt::format("force step, {} over {}", names[1], names[0]), step, step <= 1.3, "at most 1.3"));
    }
    return report;
}

constexpr const char* kHead =
    "# Accuracy and speed\n\n"
    "Made by `make bench`: medians of CPU time on one core of the machine that ran it. A time belongs to\n"
    "that machine; the errors and the ratios of one run do not. The paper's numbers are those of its\n"
    "Table 2.\n\n"
    "![Times of one tick](accuracy.png)\n\n";

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Measures speed and error of scenes that haptable-precompute has made.", "haptable-bench");
    std::vector<fs::path> scenes;
    fs::path build = "build";
    fs::path out;
    fs::path data;
    int repetitions = 9;
    double seconds = 0.05;
    app.add_option("SCENE", scenes, "scene files, already precomputed into BUILD/<name>")->required();
    app.add_option("--build", build, "where they were precomputed");
    app.add_option("-o", out, "also write the report to this Markdown file");
    app.add_option("--data", data, "also write the times in microseconds to this file, for a plot");
    app.add_option("--repetitions", repetitions, "of each measurement; the median counts");
    app.add_option("--seconds", seconds, "at least so long a repetition");
    return run_program(app, argc, argv, [&] {
        std::vector<std::unique_ptr<Case>> cases;
        for (const fs::path& scene : scenes)
            cases.push_back(std::make_unique<Case>(scene, build / read_scene(scene).name));
        const Timings timings = measure(cases, repetitions, seconds);
        const std::string text = kHead + to_markdown(make_report(timings, cases));
        fmt::print("{}", text);
        if (!out.empty()) write_file(out, text);
        std::vector<std::string> rows, names;
        for (const Measurement& measurement : kMeasurements) rows.emplace_back(measurement.row);
        for (const auto& with : cases) names.push_back(with->name);
        if (!data.empty()) write_file(data, to_plot_data(timings, rows, names));
    });
}
