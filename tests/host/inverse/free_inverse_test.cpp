// SPDX-License-Identifier: GPL-2.0-or-later
// The elastic part of a body that nothing holds, against a dense solve with its rigid motions as constraints:
//   [  K       M R ] [ u ]   [ f ]
//   [ (M R)^T   0  ] [ c ] = [ 0 ]
// c is the acceleration that f gives the body; what is left of f is in equilibrium.
#include <gtest/gtest.h>

#include <mutex>

#include "codegen/rigid_body.hpp"
#include "host/base/file.hpp"
#include "host/body/assembly.hpp"
#include "host/body/rigid_body.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/inverse/free_inverse.hpp"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kAsked = 1e-6;  // relative, of inertia relief

Scene free_cube(int nodes_per_side, Element element = Element::kLinear) {
    Scene scene = test::cube_scene(nodes_per_side, 0.45);
    test::set_free(scene);
    scene.mesh.element = element;
    return scene;
}

/// A cube of two materials, one half twice as heavy: its centre is not the mesh's.
Scene uneven_cube(int nodes_per_side, Element element) {
    Scene scene = free_cube(nodes_per_side, element);
    scene.regions.push_back({{std::array<double, 6>{-1, -1, -1, 0.015, 1, 1}, "", 1}, {3e4, 0.3}, 2000.0});
    return scene;
}

class FreeInverseOf : public testing::TestWithParam<Element> {
protected:
    MatrixXd dense_reference() const {
        const Index n = rigid.motion.rows();
        MatrixXd a = MatrixXd::Zero(n + 6, n + 6), b = MatrixXd::Zero(n + 6, n);
        a.topLeftCorner(n, n) = k * MatrixXd::Identity(n, n);
        const double size = a.diagonal().mean();  // so that all rows are alike
        for (Index c = 0; c < 6; ++c) {
            const Eigen::VectorXd column = size * rigid.momentum.col(c).normalized();
            a.block(0, n + c, n, 1) = column;
            a.block(n + c, 0, 1, n) = column.transpose();
        }
        b.topRows(n).setIdentity();
        return dense::solve(a, b).topRows(n);
    }
    void factorize(FreeInverse& by, const InverseRequest& needs = {}) {
        by.analyse(held, needs);
        by.factorize(held, progress);
    }
    /// sqrt(||L_aa|| ||L_bb||)
    static double size(const MatrixXd& l, Index a, Index b) {
        return std::sqrt(l.block<3, 3>(3 * a, 3 * a).norm() * l.block<3, 3>(3 * b, 3 * b).norm());
    }
    /// ||given - L_ab|| / sqrt(||L_aa|| ||L_bb||)
    static double error(const MatrixXd& l, const Eigen::Matrix3d& given, Index a, Index b) {
        return (given - l.block<3, 3>(3 * a, 3 * b)).norm() / size(l, a, b);
    }

    Scene scene = uneven_cube(4, GetParam());
    Body body = make_body(scene, make_mesh(scene.mesh));
    RigidBody rigid = rigid_body_of(scene, body);
    Stiffness k = assemble_free(scene, body), held = assemble_free(scene, body, hold_springs(body, k.diagonal()));
    CholmodInverse cholmod;
    FreeInverse inverse{cholmod, rigid.motion, rigid.momentum};
    Progress progress{true};
};

TEST_P(FreeInverseOf, GivesBlocksColumnsAndSolvesOfTheDenseReference) {
    const MatrixXd l = dense_reference();
    const auto nodes = std::int32_t(body.free_node.size());
    std::vector<NodePair> pairs;
    for (std::int32_t i = 0; i < nodes; i += 5)
        for (std::int32_t j = 0; j < nodes; j += 7) pairs.push_back({i, j});
    factorize(inverse, {{pairs}, {}, {}, false, 6});
    const Blocks blocks = inverse.blocks(pairs, Precision::kDouble, progress);
    double worst = 0.0;
    for (std::size_t p = 0; p < pairs.size(); ++p)
        worst = std::max(worst, error(l, blocks.l_ij[p], pairs[p].row, pairs[p].column));
    EXPECT_LT(worst, kAsked);

    MatrixXd x;
    inverse.solve(MatrixXd::Identity(l.rows(), l.rows()), x);
    EXPECT_LT((x - l).norm(), kAsked * l.norm());

    MatrixXd alone;  // of the hold: columns are rounded before the rigid motion is taken out of them
    cholmod.solve(MatrixXd::Identity(l.rows(), l.rows()), alone);
    const std::vector<std::int32_t> node{0, 9, 33}, row{2, 9, 40, 50};
    std::mutex mutex;
    std::size_t taken = 0;
    Columns::Sink sink;
    sink.take = [&](std::size_t c, std::size_t r, const Eigen::Matrix3f& block) {
        const std::lock_guard lock(mutex);
        ++taken;
        const double rounded = alone.block<3, 3>(3 * row[r], 3 * node[c]).norm() / size(l, row[r], node[c]);
        EXPECT_WITHIN(error(l, block.cast<double>(), row[r], node[c]), .count = 2, .epsilon = test::kFloat,
                      .size = 1.0 + rounded);
    };
    inverse.columns(node, row, Precision::kDouble)->compute(progress, sink);
    EXPECT_EQ(taken, node.size() * row.size());
}

TEST_P(FreeInverseOf, LoadsAndMotionsAreBalanced) {
    MatrixXd loads = MatrixXd::Random(k.size(), 3), u;
    factorize(inverse);
    inverse.solve(loads, u);
    EXPECT_LT(transposed_product(rigid.momentum, u).norm(), kAsked * rigid.momentum.norm() * u.norm());
    MatrixXd balanced = loads;
    inverse.balance(balanced);
    EXPECT_LT(transposed_product(rigid.motion, balanced).norm(), kAsked * loads.norm());
    EXPECT_LT((k * u - balanced).norm(), kAsked * loads.norm());
}

INSTANTIATE_TEST_SUITE_P(Elements, FreeInverseOf, testing::ValuesIn(every<Element>()));

// Sums over the 135 elements of a cube, an element's own of some ten roundings.
constexpr double kSums = 128.0;

TEST(RigidBody, OfACubeIsThatOfTheFormula) {
    for (const Element element : {Element::kLinear, Element::kQuadratic}) {
        const Scene scene = free_cube(4, element);
        const RigidBody rigid = rigid_body_of(scene, make_body(scene, make_mesh(scene.mesh)));
        EXPECT_WITHIN(std::abs(rigid.mass_kg - 0.027), .count = kSums, .size = 0.027);
        EXPECT_WITHIN((rigid.centre_m - Eigen::Vector3d::Constant(0.015)).norm(), .count = kSums, .size = 0.03);
        const double inertia = 0.027 * 0.03 * 0.03 / 6.0;
        EXPECT_WITHIN((rigid.inertia_kg_m2 - inertia * Eigen::Matrix3d::Identity()).norm(), .count = kSums,
                      .condition = 6.0, .size = inertia);
    }
}

TEST(RigidBody, MassScalesAllDensities) {
    Scene scene = uneven_cube(4, Element::kLinear);
    const RigidBody as_it_is = rigid_body_of(scene, make_body(scene, make_mesh(scene.mesh)));
    EXPECT_NEAR(as_it_is.mass_kg, 1.5 * 0.027, 0.2 * 0.027);
    EXPECT_LT(as_it_is.centre_m.x(), 0.0145);
    scene.free_body->mass_kg = 0.1;
    const RigidBody scaled = rigid_body_of(scene, make_body(scene, make_mesh(scene.mesh)));
    EXPECT_WITHIN(std::abs(scaled.mass_kg - 0.1), .count = kSums, .size = 0.1);
    EXPECT_WITHIN((scaled.centre_m - as_it_is.centre_m).norm(), .count = kSums, .size = 0.03);
}

TEST(RigidBody, TheServosIsTheScenes) {
    const test::TemporaryFolder folder;
    Progress quiet(true);
    Scene scene = free_cube(4);
    scene.free_body->mass_kg = 0.05;
    scene.free_body->stiffness = {1.0, 2.0, 3.0, 4e-3, 5e-3, 6e-3};
    scene.free_body->floor = FreeBody::Floor{-0.001, {0.0, 0.0, 1.0}, 0.3};
    precompute(scene, folder.path(), quiet);
    const std::optional<haptable_body> body = read_rigid_body(folder.path());
    ASSERT_TRUE(body);
    EXPECT_EQ(body->mass_kg, 0.05F);
    EXPECT_WITHIN(std::abs(double(body->centre_m[1]) - 0.015), .count = 4, .epsilon = test::kFloat, .size = 0.015);
    EXPECT_WITHIN(std::abs(double(body->inertia_kg_m2[2]) - 0.05 * 0.0009 / 6.0), .count = 4, .epsilon = test::kFloat,
                  .size = 0.05 * 0.0009 / 6.0);
    EXPECT_EQ(body->stiffness_n_per_m[1], 2.0F);
    EXPECT_EQ(body->turn_stiffness_n_m[2], 6e-3F);
    EXPECT_EQ(body->floor_m, -0.001F);
    EXPECT_EQ(body->floor_friction, 0.3F);
    EXPECT_EQ(body->point_count, 8U);
    EXPECT_EQ(body->gravity_m_per_s2[2], 0.0F);
    EXPECT_TRUE(test::says(read_file(folder.path() / "model.c"), "struct haptable_body haptable_cube4nu45_body"));
    EXPECT_TRUE(test::says(read_file(folder.path() / "model.h"), "HAPTABLE_MODEL_BODY"));
    precompute(test::cube_scene(4, 0.3), folder.path(), quiet);  // held, it has nothing of it
    EXPECT_FALSE(read_rigid_body(folder.path()));
    EXPECT_EQ(read_file(folder.path() / "model.h").find("haptable_body"), std::string::npos);
}

}  // namespace
}  // namespace haptable
