// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench: speed and error of the servo, of equation 8 and of the drawing: raw numbers as JSON, of which
// lab/programs.py makes tables beside the paper's Table 2.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

extern "C" {
#include "firmware/haptable_patch.h"
}
#include "host/base/program.hpp"
#include "host/bench/solver.hpp"
#include "host/bench/subject.hpp"
#include "host/view/painter.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kTicks = 1000;       // of a path, once round a circle
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
        haptable_servo_step(&subject.model(), &servo, path[tick].data(), 0, &out);
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

/// The finger at the path's beginning, and the loads that the servo gives for it.
ContactFrame pressed_frame(const Case& with) {
    haptable_servo servo = with.subject.touched(with.sliding);
    haptable_output out{};
    haptable_servo_step(&with.subject.model(), &servo, with.sliding.front().data(), 0, &out);
    const auto vector = [](const float x[3]) { return Eigen::Map<const Eigen::Vector3f>(x).cast<double>(); };
    ContactFrame frame;
    frame.finger_known = frame.contact = true;
    frame.finger_m = vector(with.sliding.front().data());
    frame.god_object_m = vector(out.god_object_m);
    frame.force_n = vector(out.force_n);
    const auto& node_id = with.subject.tables().node_id;  // of the free vertices, which stand first
    for (std::size_t c = 0; c < 3; ++c)
        if (out.vertex[c] < node_id.size())
            frame.loads.push_back(
                {node_id[out.vertex[c]], {out.nodal_force_n[c][0], out.nodal_force_n[c][1], out.nodal_force_n[c][2]}});
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

/// Collects the runs' times, s, by measurement and scene, and stays silent.
class Collector : public benchmark::BenchmarkReporter {
public:
    explicit Collector(ordered_json& times) : times_(times) {}
    bool ReportContext(const Context&) override { return true; }
    void ReportRuns(const std::vector<Run>& runs) override {
        for (const Run& run : runs) {
            if (run.run_type != Run::RT_Iteration) continue;
            const std::string name = run.run_name.function_name;
            const auto colon = name.find(':');
            ordered_json& time = times_[name.substr(colon + 1)][name.substr(0, colon)];
            time["cpu"].push_back(run.GetAdjustedCPUTime() * 1e-9);
            time["elapsed"].push_back(run.GetAdjustedRealTime() * 1e-9);
        }
    }

private:
    ordered_json& times_;
};

using Cases = std::vector<std::unique_ptr<Case>>;

ordered_json measure(Cases& cases, int repetitions, double seconds) {
    for (const Measurement& measurement : kMeasurements)
        for (const auto& with : cases)
            benchmark::RegisterBenchmark(
                (with->name + ":" + measurement.row).c_str(),
                [&measurement, &with](benchmark::State& state) { measurement.run(state, *with); })
                ->Repetitions(repetitions)
                ->MeasureProcessCPUTime()  // of all threads: the renderer has some
                ->MinTime(seconds);
    // Repetitions of all in turn, so that a ratio compares the same minutes of a busy machine.
    std::string program = "haptable-bench", interleave = "--benchmark_enable_random_interleaving=true";
    std::array<char*, 2> arguments{program.data(), interleave.data()};
    int count = 2;
    benchmark::Initialize(&count, arguments.data());
    ordered_json times;
    Collector collector(times);
    benchmark::RunSpecifiedBenchmarks(&collector);
    return times;
}

/// Speed of the finger on its circle, m/s: one round in kTicks milliseconds.
double finger_speed(const FingerPath& path) {
    double length = 0.0;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const auto &a = path[i], &b = path[(i + 1) % path.size()];
        length += std::hypot(static_cast<double>(b[0] - a[0]), static_cast<double>(b[1] - a[1]),
                             static_cast<double>(b[2] - a[2]));
    }
    return length / (1e-3 * static_cast<double>(path.size()));
}

/// One scene's numbers: how fast its finger goes, and how far the servo and equation 8 are from double.
ordered_json to_json(Case& with) {
    ordered_json precisions;
    for (const PrecisionError& error : with.subject.precisions())
        precisions[word(error.precision)] = {{"bytes", error.bytes}, {"worst", error.worst}};
    return {
        {"speed_m_s", finger_speed(with.sliding)},
        {"force_error", force_error(with.subject, with.sliding)},
        {"displacement_error", displacement_error(with.deformation, with.solver, with.subject.tables(), kErrorPatches)},
        {"precisions", precisions}};
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Measures speed and error of scenes that haptable-precompute has made.", "haptable-bench");
    std::vector<fs::path> scenes;
    fs::path build = "build";
    int repetitions = 9;
    double seconds = 0.05;
    app.option("SCENE", scenes, "scene files, already precomputed into BUILD/<name>").required();
    app.option("--build", build, "where they were precomputed");
    app.option("--repetitions", repetitions, "of each measurement");
    app.option("--seconds", seconds, "at least so long a repetition");
    return run_program(app, argc, argv, [&] {
        Cases cases;
        for (const fs::path& scene : scenes)
            cases.push_back(std::make_unique<Case>(scene, build / read_scene(scene).name));
        ordered_json all{{"times_s", measure(cases, repetitions, seconds)}};
        for (const auto& with : cases) all["scenes"][with->name] = to_json(*with);
        fmt::print("{}\n", all.dump());
    });
}
