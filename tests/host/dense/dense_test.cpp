// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/dense/dense.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of full rank.
MatrixXd some(Eigen::Index rows, Eigen::Index columns) {
    MatrixXd m(rows, columns);
    for (Eigen::Index k = 0; k < m.size(); ++k) m(k) = std::sin(static_cast<double>(k * k));
    return m;
}

double condition_of(const MatrixXd& spd) {
    const VectorXd values = symmetric_eigenvalues(spd);
    return values[values.size() - 1] / values[0];
}

TEST(Dense, GeneralizedEigenvaluesAreThoseThatWereGiven) {
    const MatrixXd x = some(9, 6), b = transposed_product(x, x);
    const VectorXd lambda = VectorXd::LinSpaced(6, -2.0, 3.0);
    const MatrixXd g = over_cholesky(b, b);  // B = G G^T
    const MatrixXd root = product(g, orthonormal(some(6, 6)));
    const MatrixXd a = product(root * lambda.asDiagonal(), root.transpose());
    EXPECT_WITHIN((symmetric_eigenvalues(a, b) - lambda).norm(), .count = 10, .condition = condition_of(b),
                  .size = lambda.norm());
}

}  // namespace
}  // namespace haptable
