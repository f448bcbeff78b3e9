// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench: speed and error of the servo, of equation 8 and of the drawing: raw numbers as JSON, of which
// lab/programs.py makes tables beside the paper's Table 2.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

extern "C" {
#include "firmware/haptable_patch.h"
}
#include "host/base/program.hpp"
#include "host/bench/subject.hpp"
#include "host/body/assembly.hpp"
#include "host/inverse/factor.hpp"
#include "host/view/painter.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kTicks = 1000;       // of a path, once round a circle
constexpr double kDepth = 0.002;           // m, under the surface
constexpr double kRepetition_s = 0.05;     // at the least
constexpr std::size_t kErrorPatches = 50;  // patches on which equation 8 is compared with a solve

template <typename Scalar>
Eigen::Vector3d vector(const Scalar* x) {
    return Eigen::Map<const Eigen::Matrix<Scalar, 3, 1>>(x).template cast<double>();
}

/// Unit forces, not along any axis, on the three nodes of a patch.
std::vector<NodalForce> three_loads(const Tables& tables, std::size_t patch) {
    std::vector<NodalForce> loads;
    for (std::int32_t node : tables.patch[patch]) loads.push_back({node, {0.3F, -0.2F, -0.9F}});
    return loads;
}

/// A scene of the bench with everything that is measured on it.
struct Case {
    Case(const Scene& scene, const fs::path& build)
        : name(scene.name),
          subject(read_unlimited(build / name)),
          body(make_body(scene, make_mesh(scene.mesh))),
          factor(assemble_free(scene, body)),
          deformation(subject.tables(), subject.folder()),
          painter(subject.tables(), subject.folder(), ViewOptions{}, true),
          sliding(circle(subject.tables(), kDepth, kTicks)),
          hovering(circle(subject.tables(), -kDepth, kTicks)),
          loads(three_loads(subject.tables(), subject.tables().patch.size() / 2)) {}

    /// The tables' competitor and reference, K's factor being kept: one sparse solve. Displacements of all free nodes.
    const Eigen::MatrixXd& solve(const std::vector<NodalForce>& under) {
        force_n.setZero(factor.size(), 1);
        for (const NodalForce& load : under)
            if (const std::int32_t unknown = body.unknown[static_cast<std::size_t>(load.node)]; unknown >= 0)
                force_n.middleRows<3>(Eigen::Index{3} * unknown) += vector(load.force_n.data());
        factor.solve(force_n, moved_m);
        return moved_m;
    }

    std::string name;
    LoadedScene subject;
    Body body;
    Factor factor;
    Eigen::MatrixXd force_n, moved_m;  ///< [3 unknowns, 1]
    Deformation deformation;
    Painter painter;
    FingerPath sliding, hovering;
    std::vector<NodalForce> loads;
};

/// Steps along a path, over and over.
template <FingerPath Case::*kPath>
void step_along(benchmark::State& state, Case& with) {
    const haptable_model& model = with.subject.model();
    const FingerPath& path = with.*kPath;
    haptable_servo servo = touched(model, path);
    haptable_output out{};
    std::size_t tick = 0;
    for (auto _ : state) {
        haptable_servo_step(&model, &servo, path[tick].data(), 0, &out);
        benchmark::DoNotOptimize(out);
        tick = tick + 1 == path.size() ? 0 : tick + 1;
    }
}

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
    for (auto _ : state) benchmark::DoNotOptimize(with.solve(with.loads).data());
}

/// The finger at the path's beginning, and the loads that the servo gives for it.
ContactFrame pressed_frame(const Case& with) {
    haptable_servo servo = touched(with.subject.model(), with.sliding);
    haptable_output out{};
    haptable_servo_step(&with.subject.model(), &servo, with.sliding.front().data(), 0, &out);
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
    Measurement{"force step, sliding", step_along<&Case::sliding>},
    Measurement{"force step, free", step_along<&Case::hovering>},
    Measurement{"search over all patches", search_all},
    Measurement{"equation 8", equation_8},
    Measurement{"one solve", one_solve},
    Measurement{"draw", draw},
};

using Cases = std::vector<std::unique_ptr<Case>>;

/// The runs of "SCENE:MEASUREMENT/...", as Google Benchmark tells them.
ordered_json measure(Cases& cases, int repetitions) {
    for (const Measurement& measurement : kMeasurements)
        for (const auto& with : cases)
            benchmark::RegisterBenchmark(
                (with->name + ":" + measurement.row).c_str(),
                [&measurement, &with](benchmark::State& state) { measurement.run(state, *with); })
                ->Repetitions(repetitions)
                ->MeasureProcessCPUTime()  // of all threads: the renderer has some
                ->MinTime(kRepetition_s);
    // Repetitions of all in turn, so that a ratio compares the same minutes of a busy machine.
    std::string program = "haptable-bench", interleave = "--benchmark_enable_random_interleaving=true";
    std::array<char*, 2> arguments{program.data(), interleave.data()};
    int count = 2;
    benchmark::Initialize(&count, arguments.data());
    std::ostringstream told;
    benchmark::JSONReporter reporter;
    reporter.SetOutputStream(&told);
    reporter.SetErrorStream(&told);
    benchmark::RunSpecifiedBenchmarks(&reporter);
    return ordered_json::parse(told.str())["benchmarks"];
}

/// Largest difference between equation 8 (float32 columns) and a solve in double, as a share of the largest
/// displacement, over patches spread over the surface.
double displacement_error(Case& with) {
    const Tables& tables = with.subject.tables();
    double worst = 0.0;
    for (std::size_t i = 0; i < kErrorPatches; ++i) {
        const auto loads = three_loads(tables, i * tables.patch.size() / kErrorPatches);
        const auto moved = with.deformation.displace(loads);
        const Eigen::MatrixXd& solved = with.solve(loads);
        double largest = 0.0, difference = 0.0;
        for (std::size_t r = 0; r < tables.row_id.size(); ++r) {
            const std::int32_t unknown = with.body.unknown[static_cast<std::size_t>(tables.row_id[r])];
            Eigen::Vector3d exact = Eigen::Vector3d::Zero();
            if (unknown >= 0) exact = solved.middleRows<3>(Eigen::Index{3} * unknown);
            largest = std::max(largest, exact.norm());
            difference = std::max(difference, (vector(&moved[3 * r]) - exact).norm());
        }
        if (largest > 0.0) worst = std::max(worst, difference / largest);  // 0: a patch of fixed nodes
    }
    return worst;
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Measures speed and error of scenes that haptable-precompute has made.", "haptable-bench");
    std::vector<fs::path> scenes;
    fs::path build = "build";
    int repetitions = 9;
    app.option("SCENE", scenes, "scene files, already precomputed into BUILD/<name>").required();
    app.option("--build", build, "where they were precomputed");
    app.option("--repetitions", repetitions, "of each measurement");
    return run_program(app, argc, argv, [&] {
        Cases cases;
        for (const fs::path& scene : scenes) cases.push_back(std::make_unique<Case>(read_scene(scene), build));
        ordered_json all{{"runs", measure(cases, repetitions)}};
        for (const auto& with : cases)
            all["scenes"][with->name] = {{"path_m", with->sliding}, {"displacement_error", displacement_error(*with)}};
        fmt::print("{}\n", all.dump());
    });
}
