// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/column_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include "host/inverse/factor.hpp"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/tolerance.hpp"

namespace haptable {

namespace {

using Nodes = std::vector<std::int32_t>;

/// A cube with its bottom fixed: 8 x 8 x 7 unknown nodes, enough for three groups of columns.
class SolvedColumns : public testing::Test {
protected:
    static Eigen::SparseMatrix<double> stiffness() { return test::cube_stiffness(8, 0.49); }
    static Nodes every(std::int32_t step, std::int32_t first = 0) {
        Nodes nodes;
        for (std::int32_t i = first; i < 448; i += step) nodes.push_back(i);
        return nodes;
    }
    /// Every block comes exactly once and is that of the dense inverse, to `count` roundings in float of its L_ii.
    void expect_columns(const Nodes& node, const Nodes& row, double count, Precision precision = Precision::kDouble) {
        std::vector<int> seen(node.size() * row.size(), 0);
        double largest = 0.0;
        ColumnSolver::Sink sink;
        sink.take = [&](std::size_t c, std::size_t k, const Eigen::Matrix3f& block) {
            ++seen[c * row.size() + k];
            const Eigen::Matrix3d expected = l_.block<3, 3>(3 * row[k], 3 * node[c]);
            const double scale = l_.block<3, 3>(3 * node[c], 3 * node[c]).norm();
            largest = std::max(largest, (block.cast<double>() - expected).norm() / scale);
        };
        ColumnSolver(factor_.supernodes(), node, row, precision).compute(progress_, sink);
        EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
        EXPECT_WITHIN(largest, .count = count, .epsilon = test::kFloat);
    }

    const Eigen::SparseMatrix<double> k_ = stiffness();
    const Factor factor_{k_};
    const Eigen::MatrixXd l_ = dense::inverse_spd(k_);
    Progress progress_{true};
};

constexpr double kRounded = 8.0;                      // one rounding, to float32, of entries of about the size of L_ii
const double kSolved = 8.0 * std::sqrt(3.0 * 448.0);  // forwards and backwards in float, over that many unknowns

TEST_F(SolvedColumns, OfAllNodesAtAllRows) { expect_columns(every(1), every(1), kRounded); }
TEST_F(SolvedColumns, OfSomeNodesAtMoreRows) { expect_columns(every(3), every(1), kRounded); }
TEST_F(SolvedColumns, OfMoreNodesThanRows) { expect_columns(every(1), every(5), kRounded); }
TEST_F(SolvedColumns, OfNodesThatAreNoRows) { expect_columns(every(2), every(2, 1), kRounded); }
TEST_F(SolvedColumns, OfOneNode) { expect_columns({200}, every(1), kRounded); }
TEST_F(SolvedColumns, InFloatWithItsRounding) { expect_columns(every(1), every(1), kSolved, Precision::kFloat); }

TEST_F(SolvedColumns, FewerRowsCostFewerOperations) {
    const auto flops = [&](const Nodes& node, const Nodes& row) {
        return ColumnSolver(factor_.supernodes(), node, row).flops();
    };
    const double plain = 2.0 * 3.0 * 448.0 * 2.0 * factor_.fill();
    EXPECT_LT(flops(every(1), every(1)), 0.75 * plain) << "symmetry and the path save more than a quarter";
    EXPECT_LT(flops({0}, {0}), flops({0}, every(1)));
}

}  // namespace

}  // namespace haptable
