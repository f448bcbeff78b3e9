// SPDX-License-Identifier: GPL-2.0-or-later
// A stiffness with pressures as a matrix.
#include <gtest/gtest.h>

#include <Eigen/Core>

#include "host/inverse/stiffness.hpp"
#include "tests/conditioning.hpp"
#include "tests/dense.hpp"
#include "tests/pressures.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::MatrixXd;
using Nodes = std::vector<std::int32_t>;

TEST(StiffnessWithPressures, MultipliesAsTheAssembledMatrix) {
    std::mt19937 random(1);
    const Stiffness k = test::random_stiffness(40, 2.0, random);
    const MatrixXd whole = test::assembled(k), u = MatrixXd::Random(k.size(), 11);
    const double size = whole.cwiseAbs().rowwise().sum().maxCoeff();
    EXPECT_WITHIN((k * u - dense::product(whole, u)).cwiseAbs().maxCoeff(), .count = 32.0, .size = size);
    EXPECT_WITHIN((k.diagonal() - whole.diagonal()).cwiseAbs().maxCoeff(), .count = 32.0, .size = size);
    MatrixXd shifted = whole;
    shifted.diagonal() *= 1.5;
    EXPECT_WITHIN((MatrixXd(test::assembled(k.shifted(0.5))) - shifted).cwiseAbs().maxCoeff(), .count = 32.0,
                  .size = size);
}

TEST(StiffnessWithPressures, EveryRowIsInOneBundleAndPressuresAreWithTheirNode) {
    const Stiffness::Sparse a(6, 6);
    Eigen::SparseMatrix<double, Eigen::RowMajor> g(4, 6);
    g.insert(1, 2) = 1.0;
    const Stiffness k(a, g, {1, -1, 0, 1});
    EXPECT_EQ(k.row_of_k(4), 4);
    EXPECT_EQ(k.row_of_k(7), 2) << "the one that it has an entry with";
    const auto [begin, rows] = k.bundles();
    EXPECT_EQ(begin, (Nodes{0, 4, 9, 10}));
    EXPECT_EQ(rows, (Nodes{0, 1, 2, 8, 3, 4, 5, 6, 9, 7}));
}

}  // namespace
}  // namespace haptable
