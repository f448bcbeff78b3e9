// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/pairs.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

#include "tests/bodies.hpp"
#include "tests/host/inverse/dense_reference.hpp"

namespace haptable {

namespace {

/// A cube of 9 nodes a side, its bottom fixed: 648 unknown nodes, six groups.
class Pairs : public testing::Test {
protected:
    static std::vector<NodePair> some(std::size_t count, std::int32_t nodes = 648) {
        std::mt19937 random(3);
        std::uniform_int_distribution<std::int32_t> node(0, nodes - 1);
        std::vector<NodePair> pairs;
        for (std::size_t p = 0; p < count; ++p) pairs.push_back({node(random), node(random)});
        return pairs;
    }
    double error(const CompliancePairs& pairs, const std::vector<NodePair>& wanted) {
        return dense().error(pairs.compute(progress_), wanted);
    }

    /// Once for all tests.
    static const test::DenseReference& dense() {
        static const test::DenseReference dense(test::cube_stiffness(9, 0.49));
        return dense;
    }
    static const Factor& factor() {
        static const Factor factor{dense().k};
        return factor;
    }
    static const test::Bound& bound() { return dense().bound; }

    const Factor& factor_ = factor();
    Progress progress_{true};
};

TEST_F(Pairs, AreThoseOfTheDenseInverseInEveryWay) {
    for (std::size_t count : {1U, 40U, 3000U}) {
        std::vector<NodePair> wanted = some(count);
        wanted.push_back(wanted.front());                               // twice,
        wanted.push_back({wanted.front().column, wanted.front().row});  // and the other way round
        for (auto only :
             {std::optional<PairSolve>(), std::optional(PairSolve::kPaths), std::optional(PairSolve::kSolves)})
            EXPECT_WITHIN(error(CompliancePairs(factor_.supernodes(), wanted, only), wanted), bound()) << count;
    }
}

TEST_F(Pairs, TheFewestOperationsDecide) {
    const auto flops = [&](const std::vector<NodePair>& wanted, std::optional<PairSolve> only) {
        return CompliancePairs(factor_.supernodes(), wanted, only).flops();
    };
    std::vector<NodePair> diagonal;
    for (std::int32_t i = 0; i < 648; ++i) diagonal.push_back({i, i});
    const CompliancePairs all(factor_.supernodes(), diagonal);
    EXPECT_EQ(all.method(), "selected inversion");
    EXPECT_WITHIN(error(all, diagonal), bound());
    const CompliancePairs one(factor_.supernodes(), std::vector<NodePair>{{5, 5}});
    EXPECT_EQ(one.method(), "path solves");
    for (const auto& wanted : {diagonal, some(1), some(30), some(3000)}) {
        const CompliancePairs best(factor_.supernodes(), wanted);
        EXPECT_LE(best.flops(), flops(wanted, PairSolve::kPaths));
        EXPECT_LE(best.flops(), flops(wanted, PairSolve::kSolves));
        EXPECT_GT(best.bytes(), 0.0);
    }
}

TEST_F(Pairs, InAndOutsideThePatternAtOnce) {
    std::vector<NodePair> wanted;
    for (std::int32_t i = 0; i < 648; ++i) wanted.push_back({i, i});
    wanted.push_back({3, 600});
    const CompliancePairs pairs(factor_.supernodes(), wanted);
    EXPECT_EQ(pairs.method(), "selected inversion and path solves");
    EXPECT_WITHIN(error(pairs, wanted), bound());
}

TEST_F(Pairs, TheNumberOfThreadsChangesNoBit) {
    std::vector<NodePair> wanted = some(2000);
    for (std::int32_t i = 0; i < 648; ++i) wanted.push_back({i, i});
    for (auto only :
         {std::optional<PairSolve>(), std::optional(PairSolve::kPaths), std::optional(PairSolve::kSolves)}) {
        const CompliancePairs pairs(factor_.supernodes(), wanted, only);
        const auto alone = pairs.compute(progress_);
        for (int threads : {2, 5}) {
            Workers workers(threads);
            const auto shared = pairs.compute(progress_, &workers);
            for (std::size_t p = 0; p < wanted.size(); ++p) ASSERT_EQ(shared[p], alone[p]);
        }
        EXPECT_GE(pairs.bytes(5), pairs.bytes(1));
    }
}

TEST_F(Pairs, OfNothingIsNothing) {
    const std::vector<NodePair> none;
    EXPECT_TRUE(CompliancePairs(factor_.supernodes(), none).compute(progress_).empty());
}

}  // namespace

}  // namespace haptable
