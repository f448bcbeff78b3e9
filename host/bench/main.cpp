// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench: speed against error of the servo, of equation 8 and of the drawing, beside the paper's Table 2.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>

extern "C" {
#include "firmware/haptable_patch.h"
}
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/bench/solver.hpp"
#include "host/bench/subject.hpp"
#include "host/bench/timings.hpp"
#include "host/numbers/numbers.hpp"
#include "host/view/painter.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

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

constexpr const char* kElapsed = ", elapsed";

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
            timings_.add(name.substr(colon + 1), name.substr(0, colon), run.GetAdjustedCPUTime() * 1e-9);
            timings_.add(name.substr(colon + 1) + kElapsed, name.substr(0, colon), run.GetAdjustedRealTime() * 1e-9);
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
                ->MeasureProcessCPUTime()  // of all threads: the renderer has some
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

using Cases = std::vector<std::unique_ptr<Case>>;

/// A row with a cell a case, and one beside them.
template <typename CellOf>
std::vector<Cell> row(const std::string& what, const Cases& cases, const std::string& beside, const CellOf& cell_of) {
    std::vector<Cell> cells{what};
    for (const auto& with : cases) cells.emplace_back(cell_of(*with));
    cells.emplace_back(beside);
    return cells;
}

NumberTable table(const Cases& cases, const std::string& beside) {
    NumberTable table{{""}, {}};
    for (const auto& with : cases) table.columns.push_back(with->name);
    table.columns.push_back(beside);
    return table;
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

NumberTable speed_table(const Timings& timings, const Cases& cases) {
    NumberTable speed = table(cases, "the paper (Pentium Pro, 200 MHz)");
    const auto add = [&](const std::string& what, const std::string& measured, const std::string& beside) {
        speed.rows.push_back(
            row(what, cases, beside, [&](const Case& with) { return seconds(timings.at(measured, with.name)); }));
    };
    add("force: god-object and equations 9 to 12, sliding", "force step, sliding", "15 us cube, 12 us mouse");
    add("the same tick with the finger 2 mm above the surface", "force step, free", "");
    add("for comparison: nearest point of every patch", "search over all patches", "");
    add("displacement: equation 8, three nodes, free surface", "equation 8", "158 us cube, 4181 us mouse");
    add("for comparison: one solve with a kept CHOLMOD factor", "one solve", "");
    add("one picture, 960 x 720, without PNG, CPU of all threads", "draw", "97 Hz cube, 2 Hz mouse");
    add("the same, elapsed", std::string("draw") + kElapsed, "");
    speed.rows.push_back(row("speed of the sliding finger", cases, "", [](const Case& with) {
        const double speed_m_s = finger_speed(with.sliding);
        return number(speed_m_s, fmt::format("{:.0f} mm/s", 1e3 * speed_m_s));
    }));
    return speed;
}

NumberTable error_table(const Cases& cases) {
    NumberTable error = table(cases, "against");
    error.rows.push_back(row("force in float32, sliding 2 mm deep, worst", cases, "equations 9 to 12 in double",
                             [](const Case& with) { return error_of(force_error(with.subject, with.sliding)); }));
    error.rows.push_back(row("displacement, float32 columns, worst", cases, "a solve in double", [](Case& with) {
        return error_of(displacement_error(with.deformation, with.solver, with.subject.tables(), kErrorPatches));
    }));
    return error;
}

/// The servo's blocks in 32 and 16 bits: bytes and worst force error over patches and directions.
NumberTable precision_table(const Cases& cases) {
    NumberTable precision = table(cases, "");
    for (std::size_t k = 0; k < 3; ++k) {
        precision.rows.push_back(
            row(word(cases[0]->subject.precisions()[k].precision), cases, "", [k](const Case& with) {
                const PrecisionError error = with.subject.precisions()[k];
                return Number{{static_cast<double>(error.bytes), error.worst},
                              fmt::format("{}, {:.1e}", thousands(error.bytes), error.worst)};
            }));
    }
    precision.columns.pop_back();
    for (auto& row : precision.rows) row.pop_back();
    return precision;
}

NumberTable ratio_table(const Timings& timings, const Cases& cases) {
    NumberTable ratio{{"", "value", "wanted"}, {}};
    const auto add = [&](const std::string& what, double value, bool kept, const std::string& wanted) {
        ratio.rows.push_back(
            {what, number(value, fmt::format("{:.3g}", value)), wanted + (kept ? ": kept" : ": MISSED")});
    };
    const auto step = [&](const Case& with) { return timings.at("force step, sliding", with.name); };
    for (const auto& with : cases) {
        const double solve = timings.at("one solve", with->name) / step(*with);
        add(with->name + ": one solve over a force step", solve, solve >= 30.0, "at least 30");
    }
    if (cases.size() == 2) {
        const double grown = step(*cases[1]) / step(*cases[0]);
        add(fmt::format("force step, {} over {}", cases[1]->name, cases[0]->name), grown, grown <= 1.3, "at most 1.3");
    }
    return ratio;
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Measures speed and error of scenes that haptable-precompute has made.", "haptable-bench");
    std::vector<fs::path> scenes;
    fs::path build = "build";
    fs::path out;
    int repetitions = 9;
    double seconds = 0.05;
    app.option("SCENE", scenes, "scene files, already precomputed into BUILD/<name>").required();
    app.option("--build", build, "where they were precomputed");
    app.option("-o", out, "write the numbers to this JSON file");
    app.option("--repetitions", repetitions, "of each measurement; the median counts");
    app.option("--seconds", seconds, "at least so long a repetition");
    return run_program(app, argc, argv, [&] {
        Cases cases;
        for (const fs::path& scene : scenes)
            cases.push_back(std::make_unique<Case>(scene, build / read_scene(scene).name));
        const Timings timings = measure(cases, repetitions, seconds);
        Numbers numbers("make bench");
        numbers.add("speed", speed_table(timings, cases));
        numbers.add("error", error_table(cases));
        numbers.add("ratio", ratio_table(timings, cases));
        numbers.add("precision", precision_table(cases));
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
