// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/gravity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/error.hpp"
#include "host/base/noise.hpp"
#include "host/body/assembly.hpp"
#include "host/body/small_strain.hpp"
#include "host/dense/dense.hpp"
#include "host/fem/gravity.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

Eigen::Matrix3Xd weight(const Scene& scene, const Body& body) {
    std::vector<double> density;
    for (std::int32_t region : body.region) density.push_back(scene.density_of(region));
    const auto& g = scene.gravity->acceleration_m_per_s2;
    const Laws laws = laws_of(scene, body);
    return weight_of(element_mesh(scene, body, laws), density, {g[0], g[1], g[2]});
}

/// |dS| / S of one finger, at most in any direction: S = (phi^T K phi)^-1 becomes S + dS with phi^T K_sigma phi.
double force_change(const Body& body, const NodeWeights& load, const Eigen::SparseMatrix<double>& k_sigma,
                    const LinearSolver& solver) {
    const MatrixXd w = load_matrix(load, body.unknown, solver.size());
    MatrixXd phi;
    solver.solve(w, phi);
    const Eigen::Matrix3d compliance = transposed_product(w, phi), change = transposed_product(phi, k_sigma * phi);
    return symmetric_eigenvalues(0.5 * (change + change.transpose()), 0.5 * (compliance + compliance.transpose()))
        .cwiseAbs()
        .maxCoeff();
}

/// Throws Error where a sag, linear as it is, turns tetrahedra inside out: the surface that is touched would be wrong.
void require_unturned(const Scene& scene, const Body& body, const std::vector<Eigen::Vector3d>& sag_m) {
    std::vector<Eigen::Vector3d> loaded_m = body.mesh.position_m;
    for (std::size_t i = 0; i < loaded_m.size(); ++i) loaded_m[i] += sag_m[i];
    const auto turned = std::count_if(body.mesh.tet.begin(), body.mesh.tet.end(),
                                      [&](const Tet& tet) { return six_volumes(loaded_m, tet) <= 0.0; });
    if (turned == 0) return;
    throw Error(
        fmt::format("{}: gravity: the body's weight turns {} of its {} tetrahedra inside out: make it stiffer, hold it "
                    "elsewhere, or give density in kg/m^3",
                    scene.file.string(), turned, body.mesh.tet.size()));
}

}  // namespace

std::vector<Eigen::Vector3d> find_sag(const Scene& scene, const Body& body, const LinearSolver& solver) {
    MatrixXd x;
    solver.solve(gather(weight(scene, body), body.unknown, solver.size()), x);
    const double largest_m = x.cwiseAbs().maxCoeff();  // positions are made of it
    x = x.unaryExpr([largest_m](double u) { return without_noise(u, largest_m); }).eval();
    std::vector<Eigen::Vector3d> sag_m(body.unknown.size(), Eigen::Vector3d::Zero());
    for (std::size_t k = 0; k < body.free_node.size(); ++k)
        sag_m[static_cast<std::size_t>(body.free_node[k])] = x.block<3, 1>(3 * static_cast<Index>(k), 0);
    require_unturned(scene, body, sag_m);
    return sag_m;
}

Eigen::SparseMatrix<double> prestress_of(const Scene& scene, const Body& body,
                                         const std::vector<Eigen::Vector3d>& sag_m) {
    const Eigen::Matrix3Xd u =
        Eigen::Map<const Eigen::Matrix3Xd>(sag_m.front().data(), 3, static_cast<Index>(sag_m.size()));
    const Laws laws = laws_of(scene, body);
    return geometric_stiffness(element_mesh(scene, body, laws), u, body.unknown,
                               static_cast<std::int32_t>(body.free_node.size()));
}

double buckling_factor(const Eigen::SparseMatrix<double>& k_sigma, const LinearSolver& solver) {
    const Index size = solver.size(), steps = std::min<Index>(40, size);
    MatrixXd v(size, steps), kv(size, steps), b(size, 1), x;  // v orthonormal in K's product, kv = K v
    for (Index i = 0; i < size; ++i) b(i, 0) = std::sin(1.0 + 7.0 * static_cast<double>(i));  // no symmetry
    Index count = 0;
    for (; count < steps; ++count) {
        solver.solve(b, x);
        for (int again = 0; again < 2; ++again) {
            const MatrixXd part = transposed_product(kv.leftCols(count), x);
            x -= product(v.leftCols(count), part);
            b -= product(kv.leftCols(count), part);
        }
        const double squared = x.col(0).dot(b.col(0));
        if (!(squared > 0.0)) break;
        v.col(count) = x / std::sqrt(squared);
        kv.col(count) = b / std::sqrt(squared);
        b = -(k_sigma * v.col(count));
    }
    const MatrixXd ritz = transposed_product(v.leftCols(count), k_sigma * v.leftCols(count));
    const double most = symmetric_eigenvalues(-ritz).maxCoeff();
    return most > 0.0 ? 1.0 / most : std::numeric_limits<double>::infinity();
}

GravityFacts judge_gravity(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver,
                           const std::vector<Eigen::Vector3d>& sag_m, const Eigen::SparseMatrix<double>& k_sigma) {
    GravityFacts facts;
    facts.weight_n = weight(scene, body).rowwise().sum().norm();
    for (std::size_t i = 0; i < sag_m.size(); ++i)
        if (sag_m[i].norm() > facts.largest_sag_m) {
            facts.largest_sag_m = sag_m[i].norm();
            facts.lowest_node = static_cast<std::int32_t>(i);
        }
    for (const FingerLoad& finger : fingers_on(body, masks))
        facts.force_change = std::max(facts.force_change, force_change(body, finger.load, k_sigma, solver));
    const double factor = buckling_factor(k_sigma, solver);
    facts.load_factor = std::isfinite(factor) ? factor : 0.0;
    return facts;
}

void require_unbuckled(const Scene& scene, const GravityFacts& facts) {
    if (facts.load_factor == 0.0 || facts.load_factor > 1.0) return;
    throw Error(
        fmt::format("{}: gravity: the body buckles at {:.3g} times its own weight, so that K + K_sigma is not "
                    "positive definite: make it stiffer, hold it elsewhere, or remove prestress",
                    scene.file.string(), facts.load_factor));
}

std::vector<std::string> gravity_warnings(const Scene& scene, const std::optional<GravityFacts>& facts,
                                          const Eigen::AlignedBox3d& box_m) {
    if (!facts) return {};
    std::vector<std::string> warnings;
    const std::string body = scene.file.string() + ": gravity: ";
    if (facts->largest_sag_m > GravityFacts::kMostSag * box_m.sizes().maxCoeff())
        warnings.push_back(body + fmt::format("the body sags by {:.3g} m, more than a tenth of its size, and sag is "
                                              "linear: make it stiffer, or hold it elsewhere",
                                              facts->largest_sag_m));
    if (scene.gravity->prestress || facts->force_change <= GravityFacts::kFelt) return warnings;
    const bool buckles = facts->load_factor > 0.0 && facts->load_factor <= 1.0;
    const bool is_excluded = scene.body_modes || scene.material.stiffening;
    warnings.push_back(body + fmt::format("the stress of the body's weight changes the force by up to {:.2g} %; {}",
                                          100.0 * facts->force_change,
                                          buckles ? fmt::format("it buckles at {:.3g} times that: make it stiffer, or "
                                                                "hold it elsewhere",
                                                                facts->load_factor)
                                          : is_excluded ? "prestress = true takes it, without modes and stiffening"
                                                        : "write prestress = true in [gravity] to take it"));
    return warnings;
}

std::string describe(const Scene& scene, const GravityFacts& facts) {
    return fmt::format(
        "  gravity: {:.3g} N; it sags by at most {:.3g} m (node {}); the stress of that changes the force by up to "
        "{:.2g} %{}; {}\n",
        facts.weight_n, facts.largest_sag_m, facts.lowest_node, 100.0 * facts.force_change,
        scene.gravity->prestress ? ", which is in the tables" : "",
        facts.load_factor > 0.0 ? fmt::format("it buckles at {:.3g} times its weight", facts.load_factor)
                                : "it cannot buckle");
}

}  // namespace haptable
