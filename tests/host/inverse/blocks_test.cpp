// SPDX-License-Identifier: GPL-2.0-or-later
// A stiffness as a matrix; blocks and columns of L from its factor, of linear tetrahedra and with pressures, against
// the dense inverse.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>
#include <utility>

#include "host/body/assembly.hpp"
#include "host/inverse/column_solver.hpp"
#include "host/inverse/pairs.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/host/fem/jittered_cube.hpp"
#include "tests/host/inverse/dense_reference.hpp"
#include "tests/pressures.hpp"

namespace haptable::test {
namespace {

using Eigen::MatrixXd;
using Nodes = std::vector<std::int32_t>;
using BlockList = std::vector<Eigen::Matrix3d>;

/// K of the paper's cube with inner nodes moved at random, its bottom fixed.
Stiffness uneven_cube(double poisson) {
    const Scene scene = cube_scene(5, poisson);
    return assemble_free(scene, make_body(scene, jittered_cube(5, kTop_m)));
}

Nodes every_node(const Stiffness& k) { return nodes_to(std::int32_t(k.size() / 3)); }

std::vector<NodePair> diagonal(const Stiffness& k) {
    std::vector<NodePair> pairs;
    for (std::int32_t i : every_node(k)) pairs.push_back({i, i});
    return pairs;
}

/// Every L_ii, and every L_ij of nodes that A couples.
std::vector<NodePair> pairs_in_pattern(const Stiffness& k) {
    std::vector<NodePair> pairs;
    for (std::int32_t j : every_node(k)) {
        std::int32_t last = -1;
        for (Stiffness::Sparse::InnerIterator e(k.matrix(), Eigen::Index{3} * j); e && e.row() < k.size(); ++e)
            if (const auto i = std::int32_t(e.row() / 3); i != std::exchange(last, i)) pairs.push_back({i, j});
    }
    return pairs;
}

template <typename T = double>
BlockList invert(const Factor& factor, const std::vector<NodePair>& pairs) {
    Progress quiet(true);
    return SelectedInversion(factor.supernodes(), pairs).compute<T>(quiet);
}

// ---- the matrix -----------------------------------------------------------------------------------------------------

TEST(StiffnessWithPressures, MultipliesAsTheAssembledMatrix) {
    std::mt19937 random(1);
    const Stiffness k = random_stiffness(40, 2.0, random);
    const MatrixXd whole = assembled(k), u = MatrixXd::Random(k.size(), 11);
    const double size = whole.cwiseAbs().rowwise().sum().maxCoeff();
    EXPECT_WITHIN((k * u - haptable::dense::product(whole, u)).cwiseAbs().maxCoeff(), .count = 32.0, .size = size);
    EXPECT_WITHIN((k.diagonal() - whole.diagonal()).cwiseAbs().maxCoeff(), .count = 32.0, .size = size);
    MatrixXd shifted = whole;
    shifted.diagonal() *= 1.5;
    EXPECT_WITHIN((MatrixXd(assembled(k.shifted(0.5))) - shifted).cwiseAbs().maxCoeff(), .count = 32.0, .size = size);
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

// ---- in the factor's pattern ----------------------------------------------------------------------------------------

void expect_inverse(const Stiffness& k, const std::vector<NodePair>& pairs, bool in_float_too = true) {
    const DenseReference dense(k);
    const Factor factor(k);
    const BlockList blocks = invert(factor, pairs);
    EXPECT_WITHIN(dense.error(blocks, pairs), dense.bound);
    for (std::size_t p = 0; p < pairs.size(); ++p)
        if (pairs[p].row == pairs[p].column) {
            EXPECT_EQ(blocks[p], blocks[p].transpose()) << "to the last bit";
        }
    if (!in_float_too) return;
    // From a factor in double the recurrence adds what is positive, Z_JJ = (L_JJ L_JJ^T)^-1 + Y^T Z_RR Y: an error is
    // handed down as a weighted mean, and the condition of K does not magnify it. With pressures its terms have either
    // sign, as large as those of L^-T L^-1: at most about A^-1 at the displacements, as |L| |L^T| is about K (Golub and
    // Van Loan 1979, for M^-1).
    const MatrixXd softer = haptable::dense::inverse_spd(MatrixXd(k.matrix()).topLeftCorner(k.size(), k.size()));
    const double magnified = softer.diagonal().cwiseQuotient(dense.l.diagonal()).maxCoeff();
    const double in_float = dense.error(invert<float>(factor, pairs), pairs);
    EXPECT_WITHIN(in_float, .count = 16.0 * std::sqrt(k.matrix().rows()), .epsilon = kFloat, .condition = magnified);
    EXPECT_GT(in_float, 1e-9) << "float cannot be this good: was it computed in double?";
}

TEST(SelectedInverse, OfLinearTetrahedraIsTheDenseInverse) {
    for (double poisson : {0.3, 0.4999})
        for (const Stiffness& k : {Stiffness(cube_stiffness(5, poisson)), uneven_cube(poisson)})
            expect_inverse(k, pairs_in_pattern(k));
}

TEST(SelectedInverse, WithPressuresIsTheDenseInverse) {
    for (double poisson : {0.3, 0.49, 0.4999, 0.499999})
        for (double ratio : {1.0, 1000.0}) {  // above 0.4999 the guard of precompute() takes double
            const Stiffness k = pressure_cube(6, poisson, ratio);
            expect_inverse(k, pairs_in_pattern(k), poisson <= 0.4999);
        }
    std::mt19937 random(4);
    for (double weight : {0.1, 1.0, 10.0, 1000.0}) {
        const Stiffness k = random_stiffness(80, weight, random);
        expect_inverse(k, diagonal(k), false);
    }
}

TEST(SelectedInverse, AFewPairsIsTheSameAsOfAllInTheOrderAskedFor) {
    const Stiffness k = cube_stiffness(6, 0.3);
    const Factor factor(k);
    const std::vector<NodePair> pairs = pairs_in_pattern(k);
    const BlockList all = invert(factor, pairs);
    const BlockList some = invert(factor, {pairs[100], pairs[3], pairs[57], pairs[3]});
    EXPECT_EQ(some, (BlockList{all[100], all[3], all[57], all[3]}));
    const SelectedInversion one(factor.supernodes(), std::vector<NodePair>{pairs[0]});
    const SelectedInversion every_pair(factor.supernodes(), pairs);
    EXPECT_LT(one.flops(), every_pair.flops());
    EXPECT_LE(one.stack_entries(), every_pair.stack_entries());
}

TEST(SelectedInverse, PairsOutsideThePatternAreAnError) {
    const Stiffness k = cube_stiffness(9, 0.3);
    const Factor factor(k);
    const std::int32_t last = every_node(k).back();
    std::size_t refused = 0;
    for (std::int32_t i = 0; i < last; i += 7) {
        const std::vector<NodePair> pair{{i, last - i}};
        refused += error_of([&] { SelectedInversion(factor.supernodes(), pair); }) != "no error";
    }
    EXPECT_GT(refused, 10U);
}

// ---- any pairs ------------------------------------------------------------------------------------------------------

constexpr std::optional<PairSolve> kWays[] = {std::nullopt, PairSolve::kPaths, PairSolve::kSolves};

/// A cube of 9 nodes a side, its bottom fixed, of 648 unknown nodes in six groups; and one with pressures. Made once.
class Pairs : public testing::Test {
protected:
    struct Cube {
        DenseReference dense;
        Factor factor{dense.k};
    };
    static const Cube& linear() {
        static const Cube cube{DenseReference(cube_stiffness(9, 0.49))};
        return cube;
    }
    static std::vector<NodePair> some(std::size_t count, std::int32_t nodes = 648) {
        std::mt19937 random(3);
        std::uniform_int_distribution<std::int32_t> node(0, nodes - 1);
        std::vector<NodePair> pairs;
        for (std::size_t p = 0; p < count; ++p) pairs.push_back({node(random), node(random)});
        return pairs;
    }
    void expect_right(const Cube& cube, const CompliancePairs& pairs, const std::vector<NodePair>& wanted) {
        EXPECT_WITHIN(cube.dense.error(pairs.compute(progress_), wanted), cube.dense.bound);
    }

    Progress progress_{true};
};

TEST_F(Pairs, AreThoseOfTheDenseInverseInEveryWay) {
    const Cube pressures{DenseReference(pressure_cube(6, 0.49))};
    for (const Cube* cube : {&linear(), &pressures})
        for (std::size_t count : {1U, 40U, 3000U}) {
            std::vector<NodePair> wanted = some(count, every_node(cube->dense.k).back() + 1);
            wanted.push_back(wanted.front());                               // twice,
            wanted.push_back({wanted.front().column, wanted.front().row});  // and the other way round
            for (const auto& only : kWays)
                expect_right(*cube, CompliancePairs(cube->factor.supernodes(), wanted, only), wanted);
        }
    EXPECT_TRUE(CompliancePairs(linear().factor.supernodes(), {}).compute(progress_).empty());
}

TEST_F(Pairs, TheFewestOperationsDecide) {
    const Supernodes& factor = linear().factor.supernodes();
    const std::vector<NodePair> all = diagonal(linear().dense.k), one{{5, 5}};
    std::vector<NodePair> and_one_outside = all;
    and_one_outside.push_back({3, 600});
    for (const auto& [wanted, method] : {std::pair(all, "selected inversion"),
                                         {one, "path solves"},
                                         {and_one_outside, "selected inversion and path solves"}}) {
        const CompliancePairs pairs(factor, wanted);
        EXPECT_EQ(pairs.method(), method);
        expect_right(linear(), pairs, wanted);
    }
    for (const auto& wanted : {all, some(1), some(30), some(3000)}) {
        const CompliancePairs best(factor, wanted);
        for (const PairSolve only : {PairSolve::kPaths, PairSolve::kSolves})
            EXPECT_LE(best.flops(), CompliancePairs(factor, wanted, only).flops());
        EXPECT_GT(best.bytes(), 0.0);
    }
}

TEST_F(Pairs, TheNumberOfThreadsChangesNoBit) {
    std::vector<NodePair> wanted = some(2000);
    for (const NodePair& pair : diagonal(linear().dense.k)) wanted.push_back(pair);
    for (const auto& only : kWays) {
        const CompliancePairs pairs(linear().factor.supernodes(), wanted, only);
        const auto alone = pairs.compute(progress_);
        for (int threads : {2, 5}) {
            Workers workers(threads);
            EXPECT_TRUE(pairs.compute(progress_, &workers) == alone) << threads;
        }
        EXPECT_GE(pairs.bytes(5), pairs.bytes(1));
    }
}

// ---- columns: their numbers are in inverse_test.cpp and precompute_test.cpp -----------------------------------------

TEST(SolvedColumns, FewerRowsCostFewerOperations) {
    const Factor factor(cube_stiffness(8, 0.49));
    const auto flops = [&](const Nodes& node, const Nodes& row) {
        return ColumnSolver(factor.supernodes(), node, row).flops();
    };
    const double plain = 2.0 * 3.0 * 448.0 * 2.0 * factor.fill();
    EXPECT_LT(flops(nodes_to(448), nodes_to(448)), 0.75 * plain) << "symmetry and the path save more than a quarter";
    EXPECT_LT(flops({0}, {0}), flops({0}, nodes_to(448)));
}

}  // namespace
}  // namespace haptable::test
