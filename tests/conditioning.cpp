// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/conditioning.hpp"

#include <Eigen/SparseCholesky>
#include <cmath>

namespace haptable::test {

namespace {

/// The largest eigenvalue of a positive definite operator, by powers: from below, to a few percent.
template <typename Apply>
double largest_eigenvalue(Eigen::Index size, const Apply& apply) {
    Eigen::VectorXd x =
        Eigen::VectorXd::NullaryExpr(size, [](Eigen::Index i) { return 1.0 + 0.5 * std::sin(double(i)); });
    double value = 0.0;
    for (int step = 0; step < 50; ++step) {
        x = apply(x.normalized().eval());
        value = x.norm();
    }
    return value;
}

}  // namespace

double scaled_condition(const Eigen::SparseMatrix<double>& k) {
    const Eigen::VectorXd scale = k.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SparseMatrix<double> scaled = scale.asDiagonal() * k * scale.asDiagonal();
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(scaled);
    const auto multiply = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return scaled * x; };
    const auto solve = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return factor.solve(x); };
    return largest_eigenvalue(k.rows(), multiply) * largest_eigenvalue(k.rows(), solve);
}

Eigen::SparseMatrix<double> assembled(const Stiffness& k) {
    const Eigen::SparseMatrix<double> g = k.matrix().bottomLeftCorner(k.pressures(), k.size());
    return Eigen::SparseMatrix<double>(k.matrix().topLeftCorner(k.size(), k.size())) +
           Eigen::SparseMatrix<double>(g.transpose() * g);
}

Bound inverse_bound(const Stiffness& k) {
    const Bound bound{.count = 8.0 * std::sqrt(double(k.matrix().rows())), .epsilon = kDouble};
    if (k.pressures() == 0) return bound.times(scaled_condition(k.matrix()));
    const Eigen::SparseMatrix<double> g = k.matrix().bottomLeftCorner(k.pressures(), k.size());
    const Eigen::SparseMatrix<double> a = k.matrix().topLeftCorner(k.size(), k.size()), whole = assembled(k);
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(whole), factor_of_a(a);
    Eigen::VectorXd d_p(k.pressures());
    for (Eigen::Index p = 0; p < k.pressures(); ++p) {
        const Eigen::VectorXd g_p = g.row(p).transpose();
        d_p[p] = 1.0 + g_p.dot(factor_of_a.solve(g_p));
    }
    const Eigen::VectorXd d_k = whole.diagonal();
    return bound.times(largest_eigenvalue(k.size(), [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
        const Eigen::VectorXd gx = g * x;
        return factor.solve(d_k.cwiseProduct(x) + g.transpose() * d_p.cwiseProduct(gx));
    }));
}

}  // namespace haptable::test
