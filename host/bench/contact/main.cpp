// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-contact: what the contact modes feel like and cost, as data for the plots and tables of docs/CONTACT.md and FEEL.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/bench/subject.hpp"
#include "host/precompute/precompute.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

/// How a scene is touched.
struct Mode {
    const char* force;
    const char* god_object;
    double radius_m;
};

constexpr std::array<Mode, 6> kModes = {{{"interpolated", "nearest", 0.0},
                                         {"consistent", "nearest", 0.0},
                                         {"pressure-mask", "nearest", 0.006},
                                         {"interpolated", "least-energy", 0.0},
                                         {"consistent", "least-energy", 0.0},
                                         {"pressure-mask", "least-energy", 0.006}}};

/// The scene in that mode, precomputed below `build` and ready to be touched.
std::unique_ptr<Subject> touched_as(Scene scene, const Mode& mode, const fs::path& build) {
    scene.contact.force = mode.force;
    scene.contact.god_object = mode.god_object;
    scene.contact.mask_radius_m = mode.radius_m;
    if (scene.contact.god_object == "least-energy") scene.contact.release_n_per_ms = 0.01;  // as a scene has by default
    scene.tables.columns = "none";
    const fs::path folder = build / fmt::format("{}-{}-{}", scene.name, mode.force, mode.god_object);
    Progress progress(true);
    precompute(scene, folder, progress);
    return std::make_unique<Subject>(folder);
}

Scene cube(int nodes, double poisson) {
    Scene scene;
    scene.file = "cube.toml";
    scene.name = fmt::format("cube{}", nodes);
    scene.mesh.generate = "cube";
    scene.mesh.nodes_per_side = nodes;
    scene.material = {1e4, poisson};
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, 1e-9}, "", 1});
    if (nodes > 9) scene.touch.push_back({std::array<double, 6>{0.004, 0.004, 0.03 - 1e-9, 0.026, 0.026, 1}, "", 1});
    return scene;
}

/// A finger in double on a model in float.
class Finger {
public:
    explicit Finger(const haptable_model& model) : model_(model) {
        model_.max_force_n = 1e6F;
        haptable_init(&servo_);
    }
    Vector3d to(const Vector3d& x) {
        const std::array<float, 3> finger{static_cast<float>(x.x()), static_cast<float>(x.y()),
                                          static_cast<float>(x.z())};
        haptable_step(&model_, &servo_, finger.data(), 0, &out_);
        return Eigen::Map<const Eigen::Vector3f>(out_.force_n).cast<double>();
    }

private:
    haptable_model model_;
    haptable_servo servo_{};
    haptable_output out_{};
};

/// Normal stiffness while sliding 7 mm over the top of cubes of three mesh sizes, 1 mm deep: a column a force and mesh.
std::string stiffness_along_a_line(const fs::path& build) {
    std::vector<std::unique_ptr<Subject>> subjects;
    for (int nodes : {9, 13, 17})
        for (std::size_t mode : {0U, 1U, 2U}) {
            Mode with = kModes[mode];
            if (with.radius_m > 0.0) with.radius_m = 0.005;
            subjects.push_back(touched_as(cube(nodes, 0.3), with, build));
        }
    std::vector<Finger> finger;
    for (const auto& subject : subjects) finger.emplace_back(subject->model());
    std::string text;
    for (int i = 0; i <= 700; ++i) {
        const double t = -0.0035 + 1e-5 * i;
        const Vector3d on(0.015 + 0.9487 * t, 0.0153 + 0.3162 * t, 0.03);
        text += fmt::format("{:.3f}", 1e3 * t);
        for (Finger& one : finger) {
            if (i == 0) one.to(on + Vector3d(0, 0, 0.001));
            text += fmt::format(" {:.4f}", one.to(on - Vector3d(0, 0, 0.001)).z() / 0.001);
        }
        text += "\n";
    }
    return text;
}

/// Energy that a closed loop has given to the user so far, uJ: in at the centre, 5 mm deep to (5, 6) mm aside, out,
/// over the surface back. A column a mode.
std::string energy_around_a_loop(const fs::path& build) {
    std::vector<Vector3d> path;
    const Vector3d a(0.015, 0.015, 0.03), b(0.020, 0.021, 0.03), down(0, 0, -0.005), up(0, 0, 0.0005);
    const std::array<Vector3d, 5> corner{a + up, a + down, b + down, b + up, a + up};
    for (std::size_t leg = 0; leg < 4; ++leg)
        for (int i = leg == 0 ? 0 : 1; i <= 400; ++i)
            path.push_back(corner[leg] + (corner[leg + 1] - corner[leg]) * i / 400.0);
    std::vector<std::vector<double>> given;
    for (const Mode& mode : kModes) {
        const auto subject = touched_as(cube(5, 0.3), mode, build);
        Finger finger(subject->model());
        Vector3d force = finger.to(path[0]);
        given.push_back({0.0});
        for (std::size_t i = 1; i < path.size(); ++i) {
            const Vector3d next = finger.to(path[i]);
            given.back().push_back(given.back().back() + 0.5e6 * (force + next).dot(path[i] - path[i - 1]));
            force = next;
        }
    }
    std::string text;
    for (std::size_t i = 0; i < path.size(); ++i) {
        text += fmt::format("{:.4f}", static_cast<double>(i) / 400.0);
        for (const auto& column : given) text += fmt::format(" {:.5g}", column[i]);
        text += "\n";
    }
    return text;
}

/// |F| while sliding out over the cube's convex edge, 2 mm deep at 50 mm/s: the paper's force, the same with a release
/// of 0.01 N/ms, and with the least-energy god-object, which has that by default.
std::string force_over_an_edge(const fs::path& build) {
    const auto paper = touched_as(cube(5, 0.3), kModes[0], build), least = touched_as(cube(5, 0.3), kModes[3], build);
    haptable_model released = paper->model();
    released.release = haptable_release_slew;
    released.release_n = 0.01F;
    std::array<Finger, 3> finger{Finger(paper->model()), Finger(released), Finger(least->model())};
    for (Finger& one : finger) one.to({0.022, 0.0171, 0.031});
    std::string text;
    for (int i = -40; i <= 240; ++i) {
        const Vector3d x(0.022 + 5e-5 * std::max(0, i), 0.0171, 0.03 - std::min(0.002, 5e-5 * (i + 40)));
        text += fmt::format("{}", i);
        for (Finger& one : finger) text += fmt::format(" {:.5f}", one.to(x).norm());
        text += "\n";
    }
    return text;
}

/// This process's time on its core, s: on a machine that does other work too, a clock on the wall would tell of that.
double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Median time of a step along a circle, ns; all subjects in turn, so that a ratio compares the same minutes.
std::vector<double> time_steps(const std::vector<std::unique_ptr<Subject>>& subjects, int repetitions) {
    constexpr std::size_t kTicks = 1000, kRounds = 10;
    std::vector<std::vector<double>> sample(subjects.size());
    for (int repetition = 0; repetition < repetitions; ++repetition)
        for (std::size_t s = 0; s < subjects.size(); ++s) {
            const FingerPath path = subjects[s]->circle(0.002, kTicks);
            haptable_servo servo = subjects[s]->touched(path);
            haptable_output out{};
            const double begin = cpu_s();
            for (std::size_t i = 0; i < kRounds * kTicks; ++i)
                haptable_step(&subjects[s]->model(), &servo, path[i % kTicks].data(), 0, &out);
            sample[s].push_back(1e9 * (cpu_s() - begin) / static_cast<double>(kRounds * kTicks));
        }
    std::vector<double> median;
    for (auto& one : sample) {
        std::nth_element(one.begin(), one.begin() + repetitions / 2, one.end());
        median.push_back(one[static_cast<std::size_t>(repetitions / 2)]);
    }
    return median;
}

/// A Markdown table of the step's time in each mode, and of the tables' bytes.
std::string step_table(const fs::path& build, int repetitions) {
    std::vector<std::unique_ptr<Subject>> subjects;
    const Scene mouse = read_scene("meshes/mouse.toml");
    for (const Mode& mode : kModes) {
        Mode on_cube = mode;
        if (mode.radius_m > 0.0) on_cube.radius_m = 0.012;
        subjects.push_back(touched_as(cube(5, 0.3), on_cube, build));
        subjects.push_back(touched_as(mouse, mode, build));
    }
    const std::vector<double> ns = time_steps(subjects, repetitions);
    std::string text =
        "| force | god-object | cube | mouse | over the paper's mode, cube | mouse | tables, cube | mouse |\n"
        "|---|---|---|---|---|---|---|---|\n";
    for (std::size_t m = 0; m < kModes.size(); ++m)
        text += fmt::format("| {} | {} | {:.0f} ns | {:.0f} ns | {:.2f} | {:.2f} | {} B | {} B |\n", kModes[m].force,
                            kModes[m].god_object, ns[2 * m], ns[2 * m + 1], ns[2 * m] / ns[0], ns[2 * m + 1] / ns[1],
                            subjects[2 * m]->table_bytes(), subjects[2 * m + 1]->table_bytes());
    return text;
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    CLI::App app("Measures what the contact modes feel like and cost, for docs/CONTACT.md.", "haptable-contact");
    std::filesystem::path build = "build/contact";
    int repetitions = 15;
    app.add_option("-o", build, "folder for tables and data");
    app.add_option("--repetitions", repetitions, "of each timing; the median counts");
    return haptable::run_program(app, argc, argv, [&] {
        using namespace haptable;
        write_file(build / "line.dat", stiffness_along_a_line(build));
        write_file(build / "loop.dat", energy_around_a_loop(build));
        write_file(build / "edge.dat", force_over_an_edge(build));
        const std::string steps = step_table(build, repetitions);
        write_file(build / "steps.md", steps);
        fmt::print("{}", steps);
    });
}
