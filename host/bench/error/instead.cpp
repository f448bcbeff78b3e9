// SPDX-License-Identifier: GPL-2.0-or-later
// C = w^T K^-1 w in every tick, by three ways that need no table of ours.
#include <Eigen/Dense>
#include <Eigen/IterativeLinearSolvers>
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "host/base/process_cost.hpp"
#include "host/bench/error/mask_load.hpp"
#include "host/bench/error/points.hpp"
#include "host/inverse/factor.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/body.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kResidual = 1e-3;        // relative, at which conjugate gradients stop
constexpr std::size_t kPlaces = 3;        // that are pressed; of a fine mesh one
constexpr std::size_t kDenseNodes = 800;  // more are not inverted
constexpr double kTickMotion = 4e-5;      // m: 40 mm/s

/// A body under masks of the finger's radius, in double.
class Pressed {
public:
    Pressed(const Specimen& specimen, const Meshed& meshed)
        : body_(make_body(meshed.scene, make_mesh(meshed.scene.mesh))),
          k_(assemble_free(meshed.scene, body_).matrix()),  // of linear elements
          masks_(masks_on(body_.mesh.position_m, body_.touch_patch, specimen.finger_radius_m)) {}

    const Eigen::SparseMatrix<double>& k() const { return k_; }
    const Body& body() const { return body_; }
    /// w of a finger at x, for forces along the three axes: [3 unknowns, 3].
    MatrixXd load(const Vector3d& x_m) const {
        const auto [patch, alpha] = locate(body_.mesh.position_m, body_.touch_patch, x_m);
        MatrixXd w = MatrixXd::Zero(k_.rows(), 3);
        for (const auto& [node, share] : mask_load(masks_, patch, alpha))
            if (const std::int32_t i = body_.unknown[static_cast<std::size_t>(node)]; i >= 0)
                w.middleRows<3>(Index{3} * i) += share * Matrix3d::Identity();
        return w;
    }

private:
    Body body_;
    Eigen::SparseMatrix<double> k_;
    Masks masks_;
};

/// x = K^-1 w, given the last tick's x or none.
using Solve = std::function<MatrixXd(const MatrixXd& w, const MatrixXd& last)>;

void measure(const Pressed& pressed, std::span<const Truth> truths, const Solve& solve, Point& point) {
    std::vector<double> sample;
    for (const Truth& truth : truths) {
        const Vector3d &on = truth.place.on_m, &n = truth.place.outward;
        MatrixXd w = pressed.load(on), x = solve(w, MatrixXd());
        const Matrix3d s = (w.transpose() * x).inverse();
        const Vector3d force = 0.001 * s * n;
        point.error +=
            std::pow(error_of_force(force, force_of_body(truth, false, 0.001)), 2) / static_cast<double>(truths.size());
        point.mean += (n.dot(s * n) / n.dot(truth.stiffness_n_per_m * n) - 1.0) / static_cast<double>(truths.size());
        // A tick along the patch's longest way: towards its middle.
        const auto [patch, alpha] = locate(pressed.body().mesh.position_m, pressed.body().touch_patch, on);
        Vector3d middle = Vector3d::Zero();
        for (std::int32_t node : patch) middle += pressed.body().mesh.position_m[static_cast<std::size_t>(node)] / 3.0;
        w = pressed.load(on + kTickMotion * (middle - on).normalized());
        const double begin = process_cost().cpu_s;
        x = solve(w, x);
        sample.push_back(process_cost().cpu_s - begin);
    }
    point.error = std::sqrt(point.error);
    point.tick_s = median(sample);
}

/// The inverse at the free nodes that may be touched, and their rows of w and x.
struct Dense {
    std::vector<Index> row;  ///< of K
    MatrixXd inverse;

    Dense(const Pressed& pressed, const Factor& factor) {
        for (std::int32_t node : pressed.body().touch_node)
            for (Index c = 0; c < 3; ++c)
                row.push_back(Index{3} * pressed.body().unknown[static_cast<std::size_t>(node)] + c);
        MatrixXd b = MatrixXd::Zero(factor.size(), static_cast<Index>(row.size())), x;
        for (std::size_t k = 0; k < row.size(); ++k) b(row[k], static_cast<Index>(k)) = 1.0;
        factor.solve(b, x);
        inverse = x(row, Eigen::all);
    }
    MatrixXd solve(const MatrixXd& w) const {
        MatrixXd x = MatrixXd::Zero(w.rows(), 3);
        x(row, Eigen::all) = inverse * w(row, Eigen::all);
        return x;
    }
};

MatrixXd conjugate_gradients(const Eigen::SparseMatrix<double>& k, const MatrixXd& w, const MatrixXd& last) {
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver;
    solver.setTolerance(kResidual);
    solver.compute(k);  // its diagonal
    if (last.size() > 0) return solver.solveWithGuess(w, last);
    return solver.solve(w);
}

}  // namespace

std::vector<Point> measure_instead(const Specimen& specimen, const Meshed& meshed, const std::vector<Truth>& all) {
    // A tick of conjugate gradients may take seconds.
    const auto truths = std::span(all).first(std::min(meshed.fineness == Fineness::kFine ? 1 : kPlaces, all.size()));
    const auto named = [&](const char* what) {
        return Point{specimen.name, meshed.name, "linear", what, "none", "float64"};
    };
    double begin = process_cost().cpu_s;
    const Pressed pressed(specimen, meshed);
    const double assembly_s = process_cost().cpu_s - begin;
    std::vector<Point> points{named("conjugate gradients")};
    points.back().precompute_s = assembly_s;
    measure(
        pressed, truths, [&](const MatrixXd& w, const MatrixXd& x) { return conjugate_gradients(pressed.k(), w, x); },
        points.back());
    points.back().flash_bytes = 12.0 * static_cast<double>(pressed.k().nonZeros());

    begin = process_cost().cpu_s;
    const Factor factor(pressed.k());
    const double factor_s = assembly_s + process_cost().cpu_s - begin;
    points.push_back(named("sparse solve"));
    const auto direct = [&](const MatrixXd& w, const MatrixXd& /*last*/) {
        MatrixXd x;
        factor.solve(w, x);
        return x;
    };
    measure(pressed, truths, direct, points.back());
    points.back().precompute_s = factor_s;
    points.back().flash_bytes = factor.bytes();

    if (pressed.body().touch_node.size() > kDenseNodes) return points;
    begin = process_cost().cpu_s;
    const Dense dense(pressed, factor);
    points.push_back(named("dense inverse"));
    measure(
        pressed, truths, [&](const MatrixXd& w, const MatrixXd& /*last*/) { return dense.solve(w); }, points.back());
    points.back().precompute_s = factor_s + process_cost().cpu_s - begin;
    points.back().flash_bytes = 8.0 * static_cast<double>(dense.inverse.size());
    return points;
}

}  // namespace haptable
