// SPDX-License-Identifier: GPL-2.0-or-later
// Foreseen: 1 / e = 1 / e_inf + 1 / e_1,   e_inf = 0.93 (h / R)^0.73,   e_1 = 0.0155 lambda / mu (h / R)^1.63
// Measured: e = (w . K_a^-1 w) / (w . K^-1 w) - 1,   K_a that of average nodal pressure, K^-1 its preconditioner
#include "host/body/locking.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "host/body/assembly.hpp"
#include "host/body/small_strain.hpp"

namespace haptable {

namespace {

// Below it what linear tetrahedra are too stiff by is their coarseness, not locking.
constexpr double kLeastPoisson = 0.4;
// A hand tells stiffnesses apart that differ by 8 to 22 % (Jones and Hunter 1990).
constexpr double kFelt = 0.05;

double most_poisson(const Scene& scene) {
    double most = scene.material.poisson;
    for (const Region& region : scene.regions) most = std::max(most, region.material.poisson);
    return most;
}

double volume_m3(const TetMesh& mesh) {
    double six = 0.0;
    for (const Tet& tet : mesh.tet) six += six_volumes(mesh.position_m, tet);
    return six / 6.0;
}

/// Edge of a grid's cell that is cut into five tetrahedra, where the mesh is as fine.
double mean_edge_m(const TetMesh& mesh) {
    return std::cbrt(5.0 * volume_m3(mesh) / static_cast<double>(mesh.tet.size()));
}

/// A pad around a node without a mask, (1 - r^2 / R^2)^2 on the patches that face as it does; its node alone where the
/// mesh is coarser.
NodeWeights pad_on(const Body& body, const FingerLoad& finger, double radius_m) {
    const auto at = [&](std::int32_t i) { return body.mesh.position_m[static_cast<std::size_t>(i)]; };
    const Eigen::Vector3d middle = at(finger.load.node.front());
    std::map<std::int32_t, double> share;
    for (const Patch& p : body.touch_patch) {
        const Eigen::Vector3d normal = (at(p[1]) - at(p[0])).cross(at(p[2]) - at(p[0]));
        if (!(normal.dot(finger.outward) > 0.0)) continue;
        for (const std::int32_t i : p)
            if (const double rest = 1.0 - (at(i) - middle).squaredNorm() / (radius_m * radius_m); rest > 0.0)
                share[i] += normal.norm() * rest * rest;
    }
    double sum = 0.0;
    for (const auto& [node, weight] : share) sum += weight;
    NodeWeights pad;
    for (const auto& [node, weight] : share) {
        pad.node.push_back(node);
        pad.weight.push_back(weight / sum);
    }
    return sum > 0.0 ? pad : finger.load;
}

/// Under fingers that press straight in, 1 N each: [3 n, fingers].
Eigen::MatrixXd loads_of(const Body& body, std::span<const FingerLoad> fingers, Eigen::Index size) {
    Eigen::MatrixXd load = Eigen::MatrixXd::Zero(size, std::ssize(fingers));
    for (std::size_t f = 0; f < fingers.size(); ++f) {
        const auto& [node, weight] = fingers[f].load;
        for (std::size_t k = 0; k < node.size(); ++k)
            if (const std::int32_t i = body.unknown[static_cast<std::size_t>(node[k])]; i >= 0)
                load.col(static_cast<Eigen::Index>(f)).segment<3>(Eigen::Index{3} * i) -=
                    weight[k] * fingers[f].outward;
    }
    return load;
}

/// w . K_a^-1 w over w . K^-1 w of each load, by conjugate gradients on K_a with K^-1 as preconditioner: each step adds
/// to it, so it is a bound from below wherever they end.
Eigen::ArrayXd softening(const StiffnessParts& averaged, const LinearSolver& linear, Eigen::MatrixXd r) {
    constexpr int kMostSteps = 24;
    constexpr double kEnough = 1e-3;
    Eigen::MatrixXd z, p = Eigen::MatrixXd::Zero(r.rows(), r.cols());
    Eigen::ArrayXd before, first, sum = Eigen::ArrayXd::Zero(r.cols());
    for (int step = 0; step < kMostSteps; ++step) {
        linear.solve(r, z);
        const Eigen::ArrayXd rz = r.cwiseProduct(z).colwise().sum().transpose();
        if (step == 0) first = before = rz;
        p = (z + p * (rz / before).matrix().asDiagonal()).eval();
        const Eigen::MatrixXd kp = averaged.a * p + averaged.g.transpose() * (averaged.g * p);
        const Eigen::ArrayXd length = rz / p.cwiseProduct(kp).colwise().sum().transpose().array();
        r -= kp * length.matrix().asDiagonal();
        sum += length * rz;
        before = rz;
        if ((length * rz < kEnough * sum).all()) break;
    }
    return sum / first;
}

bool can_lock(const Scene& scene) {
    return scene.mesh.element == Element::kLinear && most_poisson(scene) >= kLeastPoisson;
}

}  // namespace

double pad_radius_m(const Scene& scene, const TetMesh& mesh) {
    return scene.contact.mask_radius_m > 0.0 ? scene.contact.mask_radius_m : std::cbrt(volume_m3(mesh)) / 6.0;
}

double expected_locking(double poisson, double edge_m, double radius_m) {
    const double lambda_by_mu = 2.0 * poisson / (1.0 - 2.0 * poisson), h = edge_m / radius_m;
    return 1.0 / (1.0 / (0.93 * std::pow(h, 0.73)) + 1.0 / (0.0155 * lambda_by_mu * std::pow(h, 1.63)));
}

Locking foresee_locking(const Scene& scene, const TetMesh& mesh) {
    if (!can_lock(scene)) return {};
    const double radius_m = pad_radius_m(scene, mesh);
    return {expected_locking(most_poisson(scene), mean_edge_m(mesh), radius_m), radius_m, 0};
}

Locking measure_locking(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver) {
    // The solver's K has the stress of the weight in it, and no element has.
    if (!can_lock(scene) || (scene.gravity && scene.gravity->prestress)) return foresee_locking(scene, body.mesh);
    const Laws laws = laws_of(scene, body);
    ElementMesh mesh = element_mesh(scene, body, laws);
    mesh.element = Element::kAverageNodalPressure;
    const StiffnessParts averaged =
        assemble_stiffness(mesh, body.unknown, static_cast<std::int32_t>(body.free_node.size()));
    const double radius_m = pad_radius_m(scene, body.mesh);
    std::vector<FingerLoad> fingers = fingers_on(body, masks);
    if (masks.vertex.empty())
        for (FingerLoad& finger : fingers) finger.load = pad_on(body, finger, radius_m);
    // Beside an edge a body gives way more easily, and locks less: the most is nearest to what its faces do.
    const Eigen::ArrayXd ratio = softening(averaged, solver, loads_of(body, fingers, solver.size()));
    return {std::max(0.0, ratio.maxCoeff() - 1.0), radius_m, fingers.size()};
}

std::vector<std::string> locking_warnings(const Scene& scene, const Locking& locking) {
    if (locking.excess < kFelt) return {};
    const std::string much = locking.excess < 1.0 ? fmt::format("{:.0f} % stiffer than", 100.0 * locking.excess)
                                                  : fmt::format("{:.1f} times as stiff as", 1.0 + locking.excess);
    const std::string told =
        locking.places > 0
            ? fmt::format("feels this mesh {} by nodal pressures (the most of {} places)", much, locking.places)
            : fmt::format("is expected to feel it {} the body, or more", much);
    return {fmt::format(
        "{}: linear tetrahedra lock at Poisson's ratio {}: a finger's pad of {:.2g} m {}; write element = "
        "\"{}\" in [mesh]",
        scene.file.string(), most_poisson(scene), locking.finger_radius_m, told, word(Element::kAverageNodalPressure))};
}

}  // namespace haptable
