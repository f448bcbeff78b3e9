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

Bound inverse_bound(const Eigen::SparseMatrix<double>& k) {
    return {.count = 8.0 * std::sqrt(double(k.rows())), .epsilon = kDouble, .condition = scaled_condition(k)};
}

}  // namespace haptable::test
