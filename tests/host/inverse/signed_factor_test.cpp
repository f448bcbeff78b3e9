// SPDX-License-Identifier: GPL-2.0-or-later
// M = L S L^T of stiffnesses with pressures, and what is made of it, against dense references.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <Eigen/Core>
#include <numeric>

#include "host/inverse/column_solver.hpp"
#include "host/inverse/factor.hpp"
#include "host/inverse/numeric.hpp"
#include "host/inverse/pairs.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "host/inverse/solve/factor_file.hpp"
#include "host/inverse/solve/frame_solver.hpp"
#include "tests/bodies.hpp"
#include "tests/host/inverse/dense_reference.hpp"
#include "tests/pressures.hpp"
#include "tests/sealed.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {

namespace {

using Eigen::MatrixXd;
using Nodes = std::vector<std::int32_t>;

Eigen::Index row(std::int32_t i) { return static_cast<Eigen::Index>(i); }
std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

MatrixXd inverse_of(const Stiffness& k) { return dense::inverse_spd(MatrixXd(test::assembled(k))); }

Nodes all_nodes(const Stiffness& k) {
    Nodes nodes(static_cast<std::size_t>(k.size() / 3));
    std::iota(nodes.begin(), nodes.end(), 0);
    return nodes;
}

/// Every L_ii, and every L_ij of nodes that A couples.
std::vector<NodePair> pairs_in_pattern(const Stiffness& k) {
    std::vector<NodePair> pairs;
    for (std::int32_t j : all_nodes(k)) {
        std::int32_t last = -1;
        for (Stiffness::Sparse::InnerIterator e(k.matrix(), 3 * row(j)); e && e.row() < k.size(); ++e)
            if (const auto i = static_cast<std::int32_t>(e.row() / 3); i != std::exchange(last, i))
                pairs.push_back({i, j});
    }
    return pairs;
}

/// Largest |x - L|_ij / sqrt(L_ii L_jj).
double largest_error(const MatrixXd& x, const MatrixXd& l) {
    const Eigen::VectorXd scale = l.diagonal().cwiseSqrt().cwiseInverse();
    return (scale.asDiagonal() * (x - l) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

/// L as a whole, and S.
MatrixXd lower_triangle(const Supernodes& s) {
    MatrixXd l = MatrixXd::Zero(row(s.first_column.back()), row(s.first_column.back()));
    for (std::int32_t k = 0; k < s.count(); ++k)
        for (std::size_t j = 0; j < at(s.column_count(k)); ++j)
            for (std::size_t r = j; r < s.rows(k).size(); ++r)
                l(s.rows(k)[r], s.first_column[at(k)] + row(static_cast<std::int32_t>(j))) =
                    s.values(k)[j * s.rows(k).size() + r];
    return l;
}
Eigen::VectorXd signs(const Supernodes& s) {
    Eigen::VectorXd sign = Eigen::VectorXd::Ones(row(s.first_column.back()));
    for (std::int32_t k = 0; k < s.count(); ++k)
        sign.segment(s.first_column[at(k)] + s.positive_count(k), s.column_count(k) - s.positive_count(k)).array() = -1;
    return sign;
}

/// A factor computed by so many workers.
std::vector<double> values_by(const Stiffness& k, const Supernodes& pattern, int threads) {
    Workers workers(threads);
    Progress progress(true);
    std::vector<double> value(at(pattern.value_begin[at(pattern.count())]), 0.0);
    EXPECT_EQ(factorize(pattern, k.matrix(), value.data(), workers, progress), -1);
    return value;
}

// ---- the stiffness itself -------------------------------------------------------------------------------------------

TEST(StiffnessWithPressures, MultipliesAsTheAssembledMatrix) {
    std::mt19937 random(1);
    const Stiffness k = test::random_stiffness(40, 2.0, random);
    const MatrixXd whole = test::assembled(k), u = MatrixXd::Random(k.size(), 11);
    const double size = whole.cwiseAbs().rowwise().sum().maxCoeff();
    EXPECT_WITHIN((k * u - whole * u).cwiseAbs().maxCoeff(), .count = 32.0, .size = size);
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

// ---- the factor -----------------------------------------------------------------------------------------------------

TEST(SignedFactor, IsThatOfTheMatrixWithOneNegativePivotAPressure) {
    std::mt19937 random(2);
    for (double weight : {0.1, 1.0, 10.0, 1000.0}) {
        const Stiffness k = test::random_stiffness(60, weight, random);
        const Factor factor(k);
        const Supernodes s = factor.supernodes();
        const MatrixXd l = lower_triangle(s), m(k.matrix());
        const Eigen::VectorXd sign = signs(s);
        EXPECT_EQ((sign.array() < 0).count(), k.pressures());
        EXPECT_GT(l.diagonal().minCoeff(), 0.0);
        double largest = 0.0;
        const MatrixXd product = l * sign.asDiagonal() * l.transpose();
        const Eigen::VectorXd grown = l.rowwise().norm();  // what is added up is at most that of its row and column
        for (Eigen::Index j = 0; j < m.cols(); ++j)
            for (Eigen::Index i = j; i < m.rows(); ++i) {
                EXPECT_EQ(sign[i] < 0, s.permutation[static_cast<std::size_t>(i)] >= k.size());
                const double expected =
                    m(s.permutation[static_cast<std::size_t>(i)], s.permutation[static_cast<std::size_t>(j)]);
                largest = std::max(largest, std::abs(product(i, j) - expected) / (grown[i] * grown[j]));
            }
        EXPECT_WITHIN(largest, .count = 8.0 * std::sqrt(static_cast<double>(m.rows()))) << "weight " << weight;
    }
}

TEST(SignedFactor, SolvesForTheDisplacementsOfTheAssembledMatrix) {
    std::mt19937 random(3);
    std::vector<Stiffness> cases;
    for (double weight : {0.1, 1.0, 10.0, 1000.0}) cases.push_back(test::random_stiffness(60, weight, random));
    for (double poisson : {0.3, 0.49, 0.4999, 0.499999}) cases.push_back(test::pressure_cube(5, poisson));
    for (std::size_t c = 0; c < cases.size(); ++c) {
        const Factor factor(cases[c]);
        EXPECT_GT(factor.weakest_pivot().ratio, 1e-9);
        MatrixXd x;
        factor.solve(MatrixXd::Identity(cases[c].size(), cases[c].size()), x);
        EXPECT_WITHIN(largest_error(x, inverse_of(cases[c])), test::inverse_bound(cases[c])) << "case " << c;
    }
}

TEST(SignedFactor, TheNumberOfThreadsChangesNoBit) {
    const Stiffness k = test::pressure_cube(13, 0.49);  // its last supernode has more columns than a thread takes
    const Factor factor(k);
    const Supernodes pattern = factor.supernodes();
    const std::vector<double> alone = values_by(k, pattern, 1);
    const std::vector<NodePair> pairs = pairs_in_pattern(k);
    const SelectedInversion inversion(pattern, pairs);
    Progress progress(true);
    const auto blocks = inversion.compute<double>(progress);
    for (int threads : {2, 5}) {
        EXPECT_EQ(values_by(k, pattern, threads), alone);
        Workers workers(threads);
        EXPECT_EQ(inversion.compute<double>(progress, &workers), blocks);
    }
}

TEST(SignedFactor, ABodyThatCanMoveHasAPivotOfZero) {
    Scene scene = test::cube_scene(5, 0.49);
    scene.fixed.clear();
    const Pivot weakest =
        Factor(test::pressure_stiffness(make_body(scene, make_mesh(scene.mesh)), 0.49)).weakest_pivot();
    EXPECT_LT(weakest.ratio, 1e-13) << "below it precompute takes a pivot for zero";
    EXPECT_LT(weakest.row, 3 * 125) << "a row of K";
}

// ---- blocks and columns ---------------------------------------------------------------------------------------------

class SignedInverse : public testing::TestWithParam<double> {};  // Poisson's ratio

TEST_P(SignedInverse, IsTheDenseInverseInThePattern) {
    for (double ratio : {1.0, 1000.0}) {
        const Stiffness k = test::pressure_cube(6, GetParam(), ratio);
        const Factor factor(k);
        const test::DenseReference dense(k);
        const std::vector<NodePair> pairs = pairs_in_pattern(k);
        const SelectedInversion inversion(factor.supernodes(), pairs);
        Progress progress(true);
        EXPECT_WITHIN(dense.error(inversion.compute<double>(progress), pairs), dense.bound);
        if (GetParam() > 0.4999) continue;  // the guard of precompute() then takes double
        // What the recurrence adds are terms of either sign, as large as those of L^-T L^-1. That is at most about A^-1
        // at the displacements, as |L| |L^T| is about K (Golub and Van Loan 1979, for M^-1).
        const MatrixXd softer = haptable::dense::inverse_spd(MatrixXd(k.matrix()).topLeftCorner(k.size(), k.size()));
        const double magnified = softer.diagonal().cwiseQuotient(dense.l.diagonal()).maxCoeff();
        const double in_float = dense.error(inversion.compute<float>(progress), pairs);
        EXPECT_WITHIN(in_float, .count = 16.0 * std::sqrt(k.matrix().rows()), .epsilon = test::kFloat,
                      .condition = magnified);
        EXPECT_GT(in_float, 1e-9) << "float cannot be this good: was it computed in double?";
    }
}

INSTANTIATE_TEST_SUITE_P(Cubes, SignedInverse, testing::Values(0.3, 0.49, 0.4999, 0.499999));

TEST(SignedInverse, OfRandomMatricesIsTheDenseInverse) {
    std::mt19937 random(4);
    for (double weight : {0.1, 1.0, 10.0}) {
        const Stiffness k = test::random_stiffness(80, weight, random);
        const Factor factor(k);
        std::vector<NodePair> diagonal;
        for (std::int32_t i : all_nodes(k)) diagonal.push_back({i, i});
        Progress progress(true);
        const auto blocks = SelectedInversion(factor.supernodes(), diagonal).compute<double>(progress);
        const test::DenseReference dense(k);
        EXPECT_WITHIN(dense.error(blocks, diagonal), dense.bound) << "weight " << weight;
        for (const Eigen::Matrix3d& block : blocks) EXPECT_EQ(block, block.transpose());
    }
}

TEST(SignedInverse, PairsOutsideThePatternComeInEveryWay) {
    const Stiffness k = test::pressure_cube(6, 0.49);
    const Factor factor(k);
    const test::DenseReference dense(k);
    std::vector<NodePair> wanted;
    for (std::int32_t i : all_nodes(k)) wanted.push_back({i, (7 * i + 50) % 180});
    for (auto only :
         {std::optional<PairSolve>(), std::optional(PairSolve::kPaths), std::optional(PairSolve::kSolves)}) {
        Progress progress(true);
        const auto blocks = CompliancePairs(factor.supernodes(), wanted, only).compute(progress);
        EXPECT_WITHIN(dense.error(blocks, wanted), dense.bound);
    }
}

TEST(SignedInverse, ColumnsInFloatHaveItsRounding) {
    const Stiffness k = test::pressure_cube(8, 0.49);
    const Factor factor(k);
    const MatrixXd l = inverse_of(k);
    double largest = 0.0;
    ColumnSolver::Sink sink;
    sink.take = [&](std::size_t c, std::size_t r, const Eigen::Matrix3f& block) {
        const auto i = static_cast<Eigen::Index>(c), j = static_cast<Eigen::Index>(r);
        const double scale = l.block<3, 3>(3 * i, 3 * i).norm();
        largest = std::max(largest, (block.cast<double>() - l.block<3, 3>(3 * j, 3 * i)).norm() / scale);
    };
    Progress progress(true);
    const Nodes all = all_nodes(k);
    ColumnSolver(factor.supernodes(), all, all, Precision::kFloat).compute(progress, sink);
    EXPECT_WITHIN(largest, .count = 8.0 * std::sqrt(static_cast<double>(k.matrix().rows())), .epsilon = test::kFloat);
    EXPECT_GT(largest, 1e-9);
}

TEST(SignedInverse, AFactorFromItsFilesDisplacesAsTheDenseInverse) {
    const Stiffness k = test::pressure_cube(5, 0.49);
    const test::TemporaryFolder folder;
    const Nodes all = all_nodes(k);
    write_factor(Factor(k).supernodes(), all, folder.path());
    test::seal(folder.path(), nlohmann::json::object());
    const FactorFile file(folder.path());
    const std::vector<FrameSolver::Load> loads{{3, {1.0F, -2.0F, 0.5F}}, {90, {0.0F, 0.0F, 1.0F}}};
    FrameSolver solver(file.supernodes(), file.value().data(), all);
    const std::span<const float> displaced = solver.displace(loads);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(k.size());
    for (const FrameSolver::Load& load : loads)
        for (int c = 0; c < 3; ++c) force[3 * load.node + c] = static_cast<double>(load.force_n[c]);
    const Eigen::VectorXd expected = inverse_of(k) * force;
    const Eigen::VectorXd got = Eigen::Map<const Eigen::VectorXf>(displaced.data(), k.size()).cast<double>();
    EXPECT_WITHIN((got - expected).norm() / expected.norm(), .count = 8.0 * std::sqrt(double(k.matrix().rows())),
                  .epsilon = test::kFloat);
}

}  // namespace

}  // namespace haptable
