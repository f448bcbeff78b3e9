// SPDX-License-Identifier: GPL-2.0-or-later
// How a force leaves the linear one, against the equilibrium of the whole body at finite depths.
#include "host/body/small_strain.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "host/body/assembly.hpp"
#include "host/dense/dense.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/middles.hpp"
#include "tests/bodies.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The paper's cube, a finger on a node of its top that is not in the middle.
class SmallStrainCube : public ::testing::Test {
protected:
    SmallStrainCube()
        : scene_(test::cube_scene(5, 0.4)),
          body_(make_body(scene_, make_cube(5, 0.03))),
          solver_(scene_, body_),
          material_(materials_of(scene_, body_)) {}

    /// Forces of a neo-Hookean body, at any displacement: [3 unknowns].
    VectorXd forces(const VectorXd& x) const {
        VectorXd f = VectorXd::Zero(x.size());
        for (std::size_t t = 0; t < body_.mesh.tet.size(); ++t) {
            Corners corner;
            Eigen::Matrix<double, 3, 4> u = Eigen::Matrix<double, 3, 4>::Zero();
            std::array<std::int32_t, 4> at{};
            for (std::size_t c = 0; c < 4; ++c) {
                const auto node = std::size_t(body_.mesh.tet[t][c]);
                corner[c] = body_.mesh.position_m[node];
                at[c] = body_.unknown[node];
                if (at[c] >= 0) u.col(Eigen::Index(c)) = x.segment<3>(Eigen::Index{3} * at[c]);
            }
            const TetGeometry g = tet_geometry(corner);
            const Matrix3d deformed = Matrix3d::Identity() + u * g.gradient_per_m.transpose();
            const double j = deformed.determinant(), mu = material_[t].mu_pa;
            const double kappa = material_[t].lambda_pa + 2.0 / 3.0 * mu;
            const Matrix3d inverse = deformed.inverse().transpose();
            const Matrix3d p = mu * std::pow(j, -2.0 / 3.0) * (deformed - deformed.squaredNorm() / 3.0 * inverse) +
                               kappa * (j - 1.0) * j * inverse;
            const Eigen::Matrix<double, 3, 4> force = g.volume_m3 * p * g.gradient_per_m;
            for (std::size_t c = 0; c < 4; ++c)
                if (at[c] >= 0) f.segment<3>(Eigen::Index{3} * at[c]) += force.col(Eigen::Index(c));
        }
        return f;
    }

    /// Force along d over the linear one, the finger's node moved by t d: Newton's method with K for its slope, whose
    /// error falls by about t over an edge a step.
    double ratio(std::int32_t node, const Vector3d& d, double t) const {
        MatrixXd w = MatrixXd::Zero(solver_.size(), 3), x, step;
        w.middleRows<3>(Eigen::Index{3} * body_.unknown[std::size_t(node)]).setIdentity();
        solver_.solve(w, x);
        const Matrix3d s = Matrix3d(transposed_product(w, x)).inverse();
        const VectorXd phi = x * (s * d);
        VectorXd u = t * phi;
        for (int k = 0; k < 30; ++k) {
            solver_.solve(forces(u), step);
            u -= step - x * (s * Vector3d(transposed_product(w, step)));
        }
        return phi.dot(forces(u)) / (t * d.dot(s * d));
    }

    Scene scene_;
    Body body_;
    DenseInverse solver_;
    std::vector<Lame> material_;
};

TEST_F(SmallStrainCube, DeparturesAreThoseOfTheWholeBody) {
    constexpr std::int32_t kNode = 107;  // (2, 1, 4) of 5 x 5 x 5 nodes
    const Vector3d outward = Vector3d(0.1, -0.2, 1.0).normalized();
    const FingerLoad finger{{{kNode}, {1.0}}, outward};
    const NeoHooke body({Element::kLinear, body_.mesh.position_m, body_.mesh.tet, material_});
    const auto [pressing, pulling, sideways] = departures(body, solver_, body_.unknown, std::span(&finger, 1));
    const std::array<std::pair<Vector3d, Departure>, 4> courses{
        {{-outward, pressing.at(0)},
         {outward, pulling.at(0)},
         {outward.unitOrthogonal(), sideways.at(0)},
         {-outward.cross(outward.unitOrthogonal()), sideways.at(3)}}};
    constexpr double kStep = 2e-5;  // m, of edges of 7.5 mm: each order is some 3e-3 of the one before
    for (const auto& [way, found] : courses) {
        const double there = ratio(kNode, way, kStep), back = ratio(kNode, way, -kStep);
        const double a = (there - back) / (2.0 * kStep), b = (there + back - 2.0) / (2.0 * kStep * kStep);
        // the next order of the same parity, two on: (3e-3)^2 = 1e-5 with a factor of 10 for its coefficient
        EXPECT_WITHIN(std::abs(found.a_per_m - a), .epsilon = 1e-4, .size = std::abs(a) + std::sqrt(std::abs(b)));
        EXPECT_WITHIN(std::abs(found.b_per_m2 - b), .epsilon = 1e-4, .size = std::abs(b) + a * a);
    }
}

TEST(SmallStrain, DepthIsTheLeastWhereTheForceIsOff) {
    const auto off = [](const Departure& d, double t) { return std::abs(t * (d.a_per_m + t * d.b_per_m2)); };
    for (const Departure& d :
         {Departure{30.0, 0.0}, Departure{-30.0, 0.0}, Departure{0.0, 900.0}, Departure{30.0, 900.0},
          Departure{-30.0, 900.0}, Departure{-30.0, -900.0}, Departure{-30.0, 4000.0}}) {
        const double depth = d.depth_m(0.1);
        EXPECT_WITHIN(std::abs(off(d, depth) - 0.1), .count = 8, .size = 1.0);
        for (double share : {0.25, 0.5, 0.75, 0.99}) EXPECT_LT(off(d, share * depth), 0.1);
    }
    EXPECT_TRUE(std::isinf(Departure{}.depth_m(0.1)));
}

// Twice as large, twice as deep; as stiff as one likes.
TEST(SmallStrain, DepthScalesWithTheBodyAlone) {
    for (const Element element : every<Element>()) {
        SCOPED_TRACE(element);
        Scene scene = test::cube_scene(5, 0.4);
        scene.mesh.element = element;
        const auto depth = [&](double side, double young) {
            scene.material.young_pa = young;
            TetMesh mesh = make_cube(element == Element::kQuadratic ? 3 : 5, side);
            if (element == Element::kQuadratic) add_middles(mesh);
            const Body body = make_body(scene, std::move(mesh));
            return find_small_strain(scene, body, {}, DenseInverse(scene, body));
        };
        const auto once = depth(0.03, 1e4), twice = depth(0.06, 3e6);
        ASSERT_TRUE(once && twice);
        EXPECT_EQ(once->places, 5U);
        const Bound bound{.count = 60, .condition = 1e3, .size = 0.01};  // 73 nodes, condition of some 1e3
        EXPECT_WITHIN(std::abs(twice->pressing_m - 2.0 * once->pressing_m), bound);
        EXPECT_WITHIN(std::abs(twice->sideways_m - 2.0 * once->sideways_m), bound);
        EXPECT_GT(once->pressing_m, 1e-4);
        EXPECT_LT(once->pulling_m, 0.03);
    }
}

}  // namespace
}  // namespace haptable::test
