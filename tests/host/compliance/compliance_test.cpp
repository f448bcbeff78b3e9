// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/compliance/compliance.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "host/compliance/sample.hpp"
#include "host/inverse/factor.hpp"
#include "tests/bodies.hpp"
#include "tests/conditioning.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/host/inverse/dense_reference.hpp"

namespace haptable {
namespace {

// What an estimate by Lanczos's method still moves by when it stops.
constexpr double kSettled = 0.01;

class Blocks : public testing::Test {
protected:
    const Eigen::SparseMatrix<double> k_ = test::cube_stiffness(5, 0.3);  // 100 nodes
    const test::Bound bound_ = test::inverse_bound(k_);
    const Eigen::MatrixXd l_ = dense::inverse(k_);
    const std::vector<std::int32_t> node_ = test::nodes_to(100, 2);
    Progress progress_{true};
};

TEST_F(Blocks, ColumnsAreThoseOfTheInverse) {
    const Factor factor(k_);
    std::size_t seen = 0;
    const double residual =
        solve_columns(factor, k_, node_, progress_, [&](std::size_t first, const Eigen::MatrixXd& x) {
            ASSERT_EQ(first, seen);
            for (Eigen::Index c = 0; c < x.cols() / 3; ++c) {
                const auto column = l_.middleCols<3>(3 * node_[first + std::size_t(c)]);
                ASSERT_WITHIN((x.middleCols<3>(3 * c) - column).norm() / column.norm(), bound_);
            }
            seen += std::size_t(x.cols()) / 3;
        });
    EXPECT_EQ(seen, node_.size());
    EXPECT_GT(residual, 0.0);
    EXPECT_WITHIN(residual, bound_);  // of unit loads
}

TEST_F(Blocks, TheResidualSeesAWrongFactor) {
    Eigen::SparseMatrix<double> other = k_;
    other.coeffRef(299, 299) *= 1.0 + 1e-6;
    const double residual =
        solve_columns(Factor(other), k_, node_, progress_, [](std::size_t, const Eigen::MatrixXd&) {});
    EXPECT_GT(residual, 1e-9);
}

TEST_F(Blocks, NoPivotIsBelowTheLeastScaledEigenvalue) {
    const Eigen::VectorXd root = k_.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = root.asDiagonal() * Eigen::MatrixXd(k_) * root.asDiagonal();
    const double exact = dense::eigenvalues(scaled)[0];
    const Factor factor(k_);
    const double least = least_scaled_eigenvalue(k_, factor);
    EXPECT_WITHIN(1.0 - least / exact, bound_);  // from above, but for roundings
    EXPECT_WITHIN(least / exact - 1.0, .count = 3, .epsilon = kSettled);
    EXPECT_LE(exact, factor.weakest_pivot().ratio);
}

TEST_F(Blocks, StiffnessIsTheInverseOfTheDiagonalBlock) {
    NodeStiffness stiffness;
    for (std::int32_t node : node_) stiffness.add(node, l_.block<3, 3>(3 * node, 3 * node));
    ASSERT_EQ(stiffness.stiffness_n_per_m.size(), node_.size());
    double smallest = 1e300, condition = 0.0;
    for (std::size_t i = 0; i < node_.size(); ++i) {
        const Eigen::Matrix3d block = l_.block<3, 3>(3 * node_[i], 3 * node_[i]);
        const Eigen::Matrix3d s = stiffness.stiffness_n_per_m[i];
        const Eigen::Vector3d singular = Eigen::JacobiSVD<Eigen::Matrix3d>(block).singularValues();
        EXPECT_WITHIN((s - block.inverse()).norm() / s.norm(), .count = 16, .condition = singular[0] / singular[2]);
        EXPECT_EQ(s, s.transpose());
        smallest = std::min(smallest, singular[2]);
        condition = std::max(condition, singular[0] / singular[2]);
    }
    // A small eigenvalue errs by roundings of the largest.
    EXPECT_WITHIN(std::abs(stiffness.smallest_eigenvalue_m_per_n / smallest - 1.0), .count = 32,
                  .condition = condition);
    EXPECT_WITHIN(std::abs(stiffness.largest_condition / condition - 1.0), .count = 32, .condition = condition);
    EXPECT_TRUE(std::isinf(condition_of(Eigen::Vector3d(1.0, -1e-3, 1.0).asDiagonal())));
}

TEST_F(Blocks, ABlockThatIsNotPositiveDefiniteIsAnErrorThatNamesItsNode) {
    NodeStiffness stiffness;
    stiffness.add(70, Eigen::Matrix3d::Identity());
    const std::string said = test::error_of([&] { stiffness.add(71, Eigen::Vector3d(1.0, -1e-3, 1.0).asDiagonal()); });
    EXPECT_EQ(said.rfind("node 71: its block L_ii has the eigenvalue -0.001", 0), 0U) << said;
}

TEST_F(Blocks, ADifferenceBetweenBlocksAndSolvesIsSeen) {
    std::vector<Eigen::Matrix3d> l_ii;
    for (std::int32_t node : node_) l_ii.emplace_back(l_.block<3, 3>(3 * node, 3 * node));
    const Sample sample = solve_sample(Factor(k_), k_, node_, {}, progress_);
    ASSERT_EQ(sample.place.size(), 2 * kNodesPerBlock) << "of 50 nodes";
    EXPECT_WITHIN(sample.largest_residual, bound_);
    EXPECT_WITHIN(largest_asymmetry(sample.l), bound_);
    EXPECT_WITHIN(largest_difference(sample, l_ii), bound_);
    constexpr double kMore = 1.0 + 1e-6;
    l_ii[sample.place[20]] *= kMore;
    EXPECT_WITHIN(std::abs(largest_difference(sample, l_ii) - 1e-6), bound_);
}

TEST_F(Blocks, AsymmetryOfASymmetricInverseIsRoundingAndADisturbanceIsSeen) {
    EXPECT_WITHIN(largest_asymmetry(l_), bound_);
    for (const auto& [row, column] : {std::pair{2, 4}, {90, 94}, {2, 96}, {96, 2}}) {
        Eigen::MatrixXd disturbed = l_;
        disturbed(3 * row, 3 * column + 1) += 1e-3;
        EXPECT_GT(largest_asymmetry(disturbed), 1e-6) << row << ", " << column;
    }
}

}  // namespace
}  // namespace haptable
