// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/contact/curves.hpp"

#include <fmt/format.h>

#include "host/bench/contact/bodies.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

std::vector<double> stiffness_of(const Subject& subject, const std::vector<double>& at_m) {
    BenchFinger finger(subject.model());
    std::vector<double> n_per_m;
    for (double t : at_m) {
        const Vector3d on(0.015 + 0.9487 * t, 0.0153 + 0.3162 * t, 0.03), depth(0, 0, 0.001);
        if (n_per_m.empty()) finger.to(on + depth);
        n_per_m.push_back(finger.to(on - depth).z() / depth.z());
    }
    return n_per_m;
}

}  // namespace

StiffnessLine stiffness_along_a_line(const fs::path& build) {
    StiffnessLine line;
    for (int i = 0; i <= 700; ++i) line.at_m.push_back(-0.0035 + 1e-5 * i);
    for (int nodes : line.nodes_per_side)
        for (std::size_t mode : {0U, 1U, 2U})
            line.n_per_m.push_back(
                stiffness_of(*touched_as(contact_cube(nodes, 0.3), kContactModes[mode], 0.005, build), line.at_m));
    return line;
}

std::string StiffnessLine::text() const {
    std::string text;
    for (std::size_t i = 0; i < at_m.size(); ++i) {
        text += fmt::format("{:.3f}", 1e3 * at_m[i]);
        for (const auto& column : n_per_m) text += fmt::format(" {:.4f}", column[i]);
        text += "\n";
    }
    return text;
}

std::string energy_around_a_loop(const fs::path& build) {
    std::vector<Vector3d> path;
    const Vector3d a(0.015, 0.015, 0.03), b(0.020, 0.021, 0.03), down(0, 0, -0.005), up(0, 0, 0.0005);
    const std::array<Vector3d, 5> corner{a + up, a + down, b + down, b + up, a + up};
    for (std::size_t leg = 0; leg < 4; ++leg)
        for (int i = leg == 0 ? 0 : 1; i <= 400; ++i)
            path.push_back(corner[leg] + (corner[leg + 1] - corner[leg]) * i / 400.0);
    std::vector<std::vector<double>> given;
    for (const ContactMode& mode : kContactModes) {
        const auto subject = touched_as(contact_cube(5, 0.3), mode, 0.006, build);
        BenchFinger finger(subject->model());
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

std::string force_over_an_edge(const fs::path& build) {
    const auto paper = touched_as(contact_cube(5, 0.3), kContactModes[0], 0.0, build);
    const auto least = touched_as(contact_cube(5, 0.3), kContactModes[3], 0.0, build);
    haptable_model released = paper->model();
    released.release = haptable_release_slew;
    released.release_n = 0.01F;
    std::array<BenchFinger, 3> finger{BenchFinger(paper->model()), BenchFinger(released), BenchFinger(least->model())};
    for (BenchFinger& one : finger) one.to({0.022, 0.0171, 0.031});
    std::string text;
    for (int i = -40; i <= 240; ++i) {
        const Vector3d x(0.022 + 5e-5 * std::max(0, i), 0.0171, 0.03 - std::min(0.002, 5e-5 * (i + 40)));
        text += fmt::format("{}", i);
        for (BenchFinger& one : finger) text += fmt::format(" {:.5f}", one.to(x).norm());
        text += "\n";
    }
    return text;
}

}  // namespace haptable
