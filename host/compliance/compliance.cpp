// SPDX-License-Identifier: GPL-2.0-or-later
// K X = E_I,   L_ri = X at row r and column i,   S_i = (L_ii)^-1
#include "host/compliance/compliance.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include "host/base/error.hpp"
#include "host/base/index.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

/// The unit loads E_I of one block of nodes, [3 unknowns, 3 count].
void set_unit_loads(std::span<const std::int32_t> node, Eigen::MatrixXd& b) {
    b.setZero();
    for (std::size_t c = 0; c < node.size(); ++c) b.block<3, 3>(dof(node[c]), dof(c)).setIdentity();
}

/// Largest ||K x - b|| / ||b|| of the columns of one block; the norm of a unit load is 1.
double block_residual(const Stiffness& k, const Eigen::MatrixXd& x, const Eigen::MatrixXd& b) {
    constexpr Eigen::Index kPanel = 8;  // columns at a time: the residual of all would be one more right-hand side each
    double largest = 0.0;
    for (Eigen::Index first = 0; first < x.cols(); first += kPanel) {
        const Eigen::Index count = std::min(kPanel, x.cols() - first);
        const Eigen::MatrixXd residual = k * x.middleCols(first, count) - b.middleCols(first, count);
        largest = std::max(largest, residual.colwise().norm().maxCoeff());
    }
    return largest;
}

/// The largest eigenvalue of a symmetric operator, by Lanczos's method with full orthogonalisation.
double dominant_eigenvalue(Eigen::Index size, const std::function<void(const Eigen::MatrixXd&, Eigen::MatrixXd&)>& a) {
    constexpr int kMostSteps = 40, kSettled = 3;
    const int most = static_cast<int>(std::min<Eigen::Index>(kMostSteps, size));
    Eigen::MatrixXd basis(size, most), t = Eigen::MatrixXd::Zero(most, most), x(size, 1), next;
    for (Eigen::Index i = 0; i < size; ++i) x(i, 0) = 1.0 + 0.5 * std::sin(static_cast<double>(i));  // no symmetry
    x.normalize();
    std::vector<double> value;
    for (int step = 0; step < most; ++step) {
        basis.col(step) = x.col(0);
        a(x, next);
        t(step, step) = x.col(0).dot(next.col(0));
        value.push_back(symmetric_eigenvalues(t.topLeftCorner(step + 1, step + 1))[step]);
        if (step >= kSettled && value.back() - value[value.size() - 1 - kSettled] <= 0.01 * value.back()) break;
        const auto known = basis.leftCols(step + 1);
        for (int twice = 0; twice < 2; ++twice) next -= product(known, transposed_product(known, next));
        const double norm = next.norm();
        if (step + 1 == most || norm <= 1e-12 * value.back()) break;
        t(step + 1, step) = t(step, step + 1) = norm;
        x = next / norm;
    }
    return value.back();
}

}  // namespace

double solve_columns(const LinearSolver& solver, const Stiffness& k, std::span<const std::int32_t> node,
                     Progress& progress, const TakeColumns& take) {
    double largest_residual = 0.0;
    Eigen::MatrixXd b, x;
    for (std::size_t first = 0; first < node.size(); first += kNodesPerBlock) {
        progress.done(static_cast<double>(first) / static_cast<double>(node.size()));
        const std::size_t count = std::min(kNodesPerBlock, node.size() - first);
        b.resize(solver.size(), dof(count));
        set_unit_loads(node.subspan(first, count), b);
        solver.solve(b, x);
        solver.balance(b);
        largest_residual = std::max(largest_residual, block_residual(k, x, b));
        take(first, x);
    }
    return largest_residual;
}

double condition_of(const Eigen::Matrix3d& block) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(block, Eigen::EigenvaluesOnly);
    const double condition = eigen.eigenvalues()[2] / eigen.eigenvalues()[0];
    return condition > 0.0 ? condition : std::numeric_limits<double>::infinity();
}

void NodeStiffness::add(std::int32_t mesh_node, const Eigen::Matrix3d& l_ii) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(l_ii, Eigen::EigenvaluesOnly);
    const double smallest = eigen.eigenvalues()[0];
    if (!l_ii.allFinite() || !(smallest > 0.0))
        throw Error(
            fmt::format("node {}: its block L_ii has the eigenvalue {:.3g} where all should be positive: K is "
                        "too badly conditioned; mend slivers in the mesh, or lower a Poisson's ratio near 0.5",
                        mesh_node, smallest));
    // Inverting by Cholesky loses the fewest digits where L_ii is badly conditioned (Poisson's ratio near 0.5).
    const Eigen::Matrix3d inverse = inverse_spd(l_ii);
    smallest_eigenvalue_m_per_n =
        stiffness_n_per_m.empty() ? smallest : std::min(smallest_eigenvalue_m_per_n, smallest);
    largest_condition = std::max(largest_condition, condition_of(l_ii));
    stiffness_n_per_m.emplace_back(0.5 * (inverse + inverse.transpose()));
}

double largest_asymmetry(const Eigen::MatrixXd& l) {
    const auto norm = [&](Eigen::Index i) { return l.block<3, 3>(i, i).norm(); };
    double largest = 0.0;
    for (Eigen::Index i = 0; i < l.rows(); i += 3)
        for (Eigen::Index j = 0; j < i; j += 3) {
            const double difference = (l.block<3, 3>(i, j) - l.block<3, 3>(j, i).transpose()).norm();
            largest = std::max(largest, difference / std::sqrt(norm(i) * norm(j)));
        }
    return largest;
}

double estimate_condition(const Stiffness& k, const LinearSolver& solver) {
    const double largest =
        dominant_eigenvalue(k.size(), [&](const Eigen::MatrixXd& x, Eigen::MatrixXd& y) { y = k * x; });
    const double inverse_of_smallest =
        dominant_eigenvalue(k.size(), [&](const Eigen::MatrixXd& x, Eigen::MatrixXd& y) { solver.solve(x, y); });
    return largest * inverse_of_smallest;
}

double least_scaled_eigenvalue(const Stiffness& k, const LinearSolver& solver) {
    const Eigen::VectorXd root = k.diagonal().cwiseSqrt();
    Eigen::MatrixXd scaled;
    return 1.0 / dominant_eigenvalue(k.size(), [&](const Eigen::MatrixXd& x, Eigen::MatrixXd& y) {
               scaled = root.asDiagonal() * x;
               solver.solve(scaled, y);
               y = root.asDiagonal() * y;
           });
}

double estimate_scaled_condition(const Stiffness& k, const LinearSolver& solver) {
    const Eigen::VectorXd root = k.diagonal().cwiseSqrt().cwiseInverse();
    const double largest = dominant_eigenvalue(k.size(), [&](const Eigen::MatrixXd& x, Eigen::MatrixXd& y) {
        y = root.asDiagonal() * (k * (root.asDiagonal() * x).eval());
    });
    return largest / least_scaled_eigenvalue(k, solver);
}

}  // namespace haptable
