// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/selected_inversion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

#include "host/base/error.hpp"
#include "host/body/assembly.hpp"
#include "host/fem/elasticity.hpp"
#include "tests/error_of.hpp"
#include "tests/host/inverse/dense_reference.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// The paper's cube, its bottom fixed; `jitter`: nodes moved at random, as a share of the cell.
Body cube_body(Scene& scene, int nodes_per_side, double poisson, double jitter) {
    scene.mesh.generate = "cube";
    scene.mesh.nodes_per_side = nodes_per_side;
    scene.mesh.side_m = 0.03;
    scene.material = {1e4, poisson};
    scene.fixed = {{std::array<double, 6>{-1, -1, -1, 1, 1, 1e-9}, "", 1}};
    Body body = make_body(scene, make_mesh(scene.mesh));
    std::mt19937 random(7);
    std::uniform_real_distribution<double> offset(-jitter, jitter);
    const double cell_m = 0.03 / (nodes_per_side - 1);
    for (Eigen::Vector3d& p : body.mesh.position_m)
        p += cell_m * Eigen::Vector3d(offset(random), offset(random), offset(random));
    return body;
}

/// Every L_ii and every L_ij of two nodes that share a tetrahedron, both ways round.
std::vector<NodePair> all_pairs(const Body& body) {
    std::vector<NodePair> pairs;
    for (const Tet& tet : body.mesh.tet)
        for (std::int32_t a : tet)
            for (std::int32_t b : tet)
                if (!body.is_fixed(a) && !body.is_fixed(b))
                    pairs.push_back(
                        {body.unknown[static_cast<std::size_t>(a)], body.unknown[static_cast<std::size_t>(b)]});
    return pairs;
}

template <typename T>
std::vector<Eigen::Matrix3d> compute(const Factor& factor, const std::vector<NodePair>& pairs) {
    Progress progress(true);
    return SelectedInversion(factor.supernodes(), pairs).compute<T>(progress);
}

class SelectedInverse : public testing::TestWithParam<std::pair<double, double>> {};  // Poisson's ratio, jitter

TEST_P(SelectedInverse, IsTheDenseInverseInThePattern) {
    const auto [poisson, jitter] = GetParam();
    Scene scene;
    const Body body = cube_body(scene, 5, poisson, jitter);
    const test::DenseReference dense(assemble_free(scene, body));
    const Factor factor(dense.k);
    const std::vector<NodePair> pairs = all_pairs(body);
    EXPECT_WITHIN(dense.error(compute<double>(factor, pairs), pairs), dense.bound);
    const double in_float = dense.error(compute<float>(factor, pairs), pairs);
    // The recurrence adds what is positive, Z_JJ = (L_JJ L_JJ^T)^-1 + Y^T Z_RR Y, from a factor in double: an error is
    // handed down as a weighted mean, and the condition of K does not magnify it.
    EXPECT_WITHIN(in_float, .count = 16.0 * std::sqrt(factor.size()), .epsilon = test::kFloat);
    EXPECT_GT(in_float, 1e-9) << "float cannot be this good: was it computed in double?";
}

INSTANTIATE_TEST_SUITE_P(Cubes, SelectedInverse,
                         testing::Values(std::pair{0.3, 0.0}, std::pair{0.3, 0.2}, std::pair{0.4999, 0.0},
                                         std::pair{0.4999, 0.2}));

TEST(SelectedInverseOf, AFewPairsIsTheSameAsOfAllInTheOrderAskedFor) {
    Scene scene;
    const Body body = cube_body(scene, 6, 0.3, 0.0);
    const Factor factor(assemble_free(scene, body));
    const std::vector<NodePair> pairs = all_pairs(body);
    const std::vector<Eigen::Matrix3d> all = compute<double>(factor, pairs);
    const std::vector<NodePair> few{pairs[100], pairs[3], pairs[57], pairs[3]};
    const std::vector<Eigen::Matrix3d> some = compute<double>(factor, few);
    EXPECT_EQ(some[0], all[100]);
    EXPECT_EQ(some[1], all[3]);
    EXPECT_EQ(some[2], all[57]);
    EXPECT_EQ(some[3], all[3]);
    Progress progress(true);
    const SelectedInversion one(factor.supernodes(), std::vector<NodePair>{pairs[0]});
    const SelectedInversion every(factor.supernodes(), pairs);
    EXPECT_LT(one.flops(), every.flops());
    EXPECT_LE(one.stack_entries(), every.stack_entries());
}

TEST(SelectedInverseOf, DiagonalBlocksAreSymmetricToTheLastBitAndRunsRepeat) {
    Scene scene;
    const Body body = cube_body(scene, 6, 0.49, 0.2);
    const Factor factor(assemble_free(scene, body));
    std::vector<NodePair> diagonal;
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(body.free_node.size()); ++i) diagonal.push_back({i, i});
    const auto first = compute<double>(factor, diagonal), second = compute<double>(factor, diagonal);
    for (std::size_t i = 0; i < first.size(); ++i) {
        EXPECT_EQ(first[i], first[i].transpose());
        EXPECT_EQ(first[i], second[i]);
    }
}

TEST(SelectedInverseOf, PairsOutsideThePatternAreAnError) {
    Scene scene;
    const Body body = cube_body(scene, 9, 0.3, 0.0);
    const Factor factor(assemble_free(scene, body));
    const auto last = static_cast<std::int32_t>(body.free_node.size()) - 1;
    std::size_t refused = 0;
    for (std::int32_t i = 0; i < last; i += 7) {
        const std::vector<NodePair> pair{{i, last - i}};
        refused += test::error_of([&] { SelectedInversion(factor.supernodes(), pair); }) != "no error";
    }
    EXPECT_GT(refused, 10U);
}

TEST(SelectedInverseOf, TheMouseAgreesWithSolves) {
    const Scene scene = read_scene("meshes/mouse.toml");
    const Body body = make_body(scene, make_mesh(scene.mesh));
    const Eigen::SparseMatrix<double> k = assemble_free(scene, body).matrix();
    const Factor factor(k);
    const std::vector<NodePair> pairs = all_pairs(body);
    const std::vector<Eigen::Matrix3d> block = compute<double>(factor, pairs);
    const test::Bound bound = test::inverse_bound(k);
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(factor.size(), 3), x;
    for (std::int32_t j = 0; j < factor.size() / 3; j += 97) {
        b.setZero();
        b.middleRows<3>(3 * j).setIdentity();
        factor.solve(b, x);
        const double scale = x.middleRows<3>(3 * j).norm();
        for (std::size_t p = 0; p < pairs.size(); ++p)
            if (pairs[p].column == j) {
                EXPECT_WITHIN((block[p] - x.middleRows<3>(3 * pairs[p].row)).norm() / scale, bound);
            }
    }
}

}  // namespace

}  // namespace haptable
