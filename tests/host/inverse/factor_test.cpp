// SPDX-License-Identifier: GPL-2.0-or-later
// M = L S L^T of stiffnesses with pressures, and its files, against dense references.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <Eigen/Core>

#include "host/inverse/factor.hpp"
#include "host/inverse/numeric.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "host/inverse/solve/factor_file.hpp"
#include "host/inverse/solve/frame_solver.hpp"
#include "tests/host/inverse/dense_reference.hpp"
#include "tests/pressures.hpp"
#include "tests/sealed.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

using Eigen::MatrixXd;
using Nodes = std::vector<std::int32_t>;

Eigen::Index row(std::int32_t i) { return Eigen::Index(i); }
std::size_t at(std::int32_t i) { return std::size_t(i); }

MatrixXd inverse_of(const Stiffness& k) { return dense::inverse_spd(MatrixXd(test::assembled(k))); }

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
                l(s.rows(k)[r], s.first_column[at(k)] + row(std::int32_t(j))) = s.values(k)[j * s.rows(k).size() + r];
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
        const MatrixXd product = dense::product(l * sign.asDiagonal(), l.transpose());
        const Eigen::VectorXd grown = l.rowwise().norm();  // what is added up is at most that of its row and column
        for (Eigen::Index j = 0; j < m.cols(); ++j)
            for (Eigen::Index i = j; i < m.rows(); ++i) {
                EXPECT_EQ(sign[i] < 0, s.permutation[std::size_t(i)] >= k.size());
                const double expected = m(s.permutation[std::size_t(i)], s.permutation[std::size_t(j)]);
                largest = std::max(largest, std::abs(product(i, j) - expected) / (grown[i] * grown[j]));
            }
        EXPECT_WITHIN(largest, .count = 8.0 * std::sqrt(double(m.rows()))) << "weight " << weight;
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
    std::vector<NodePair> diagonal;
    for (std::int32_t i : test::nodes_to(std::int32_t(k.size() / 3))) diagonal.push_back({i, i});
    const SelectedInversion inversion(pattern, diagonal);
    Progress progress(true);
    const auto blocks = inversion.compute<double>(progress);
    for (int threads : {2, 5}) {
        EXPECT_EQ(values_by(k, pattern, threads), alone);
        Workers workers(threads);
        EXPECT_EQ(inversion.compute<double>(progress, &workers), blocks);
    }
}

TEST(SignedFactor, FromItsFilesDisplacesAsTheDenseInverse) {
    const Stiffness k = test::pressure_cube(5, 0.49);
    const test::TemporaryFolder folder;
    const Nodes all = test::nodes_to(std::int32_t(k.size() / 3));
    write_factor(Factor(k).supernodes(), all, folder.path());
    test::seal(folder.path(), nlohmann::json::object());
    const FactorFile file(folder.path());
    const std::vector<FrameSolver::Load> loads{{3, {1.0F, -2.0F, 0.5F}}, {90, {0.0F, 0.0F, 1.0F}}};
    FrameSolver solver(file.supernodes(), file.value().data(), all);
    const std::span<const float> displaced = solver.displace(loads);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(k.size());
    for (const FrameSolver::Load& load : loads)
        for (int c = 0; c < 3; ++c) force[3 * load.node + c] = double(load.force_n[c]);
    const Eigen::VectorXd expected = inverse_of(k) * force;
    const Eigen::VectorXd got = Eigen::Map<const Eigen::VectorXf>(displaced.data(), k.size()).cast<double>();
    EXPECT_WITHIN((got - expected).norm() / expected.norm(), .count = 8.0 * std::sqrt(double(k.matrix().rows())),
                  .epsilon = test::kFloat);
}

}  // namespace
}  // namespace haptable
