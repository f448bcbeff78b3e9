// SPDX-License-Identifier: GPL-2.0-or-later
// A body that stiffens: its forces against its energy, its dents against its rest, and the curve that they are given.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>

#include "host/base/error.hpp"
#include "host/body/assembly.hpp"
#include "host/body/indentation.hpp"
#include "host/body/stiffening_fit.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "tests/bodies.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A cube with a held base, its K and one material that stiffens.
struct StiffCube {
    StiffCube(int nodes, double poisson, const Stiffening& stiffening, Element element = Element::kLinear)
        : scene(make_scene(nodes, poisson, stiffening, element)),
          body(make_body(scene, make_mesh(scene.mesh))),
          material(materials_of(scene, body)),
          hyper({element, body.mesh.position_m, body.mesh.tet, material, body.mesh.middle}, stiffening) {
        const Stiffness k = assemble_free(scene, body);
        inverse.analyse(k, {});
        inverse.factorize(k, quiet);
    }
    static Scene make_scene(int nodes, double poisson, const Stiffening& stiffening, Element element) {
        Scene scene = test::cube_scene(nodes, poisson);
        scene.mesh.element = element;
        scene.material.stiffening = stiffening;
        return scene;
    }
    /// The node nearest to the middle of the top, and around it within a radius.
    FingerLoad finger(double radius_m) const {
        FingerLoad load;
        load.outward = Vector3d::UnitZ();
        double sum = 0.0;
        for (const std::int32_t node : body.touch_node) {
            const double r = (body.mesh.position_m[std::size_t(node)] - Vector3d(0.015, 0.015, 0.03)).norm() / radius_m;
            if (!(r < 1.0)) continue;
            load.load.node.push_back(node);
            load.load.weight.push_back(std::pow(1.0 - r * r, 2));
            sum += load.load.weight.back();
        }
        for (double& weight : load.load.weight) weight /= sum;
        return load;
    }

    Progress quiet{true};
    Scene scene;
    Body body;
    std::vector<Lame> material;
    Hyperelastic hyper;
    CholmodInverse inverse{1};
};

class Hyperelasticity : public testing::TestWithParam<std::tuple<Element, bool>> {};

INSTANTIATE_TEST_SUITE_P(Elements, Hyperelasticity,
                         testing::Combine(testing::ValuesIn(every<Element>()), testing::Bool()));

TEST_P(Hyperelasticity, ForcesAreTheEnergysGradientAndTheLinearBodysAtRest) {
    const auto [element, is_fung] = GetParam();
    const StiffCube cube(3, 0.4, is_fung ? Stiffening{0.0, 0.0, 4.0, {}} : Stiffening{5.0, 2.0, 0.0, {}}, element);
    std::mt19937 random(1);
    std::normal_distribution<double> any;
    const auto count = Eigen::Index(std::max(cube.body.unknown.size(), cube.body.mesh.position_m.size()));
    Matrix3Xd u(3, count), way(3, count), f, unused;
    for (double& value : u.reshaped()) value = 4e-4 * any(random);  // of cells of 15 mm
    for (double& value : way.reshaped()) value = any(random);
    constexpr double kStep = 1e-6;
    ASSERT_TRUE(std::isfinite(cube.hyper.energy(u, f)));
    const double slope =
        (cube.hyper.energy(u + kStep * way, unused) - cube.hyper.energy(u - kStep * way, unused)) / (2.0 * kStep);
    EXPECT_WITHIN(slope - f.cwiseProduct(way).sum(), .epsilon = 1e-6, .size = f.norm() * way.norm());

    const Stiffness k = assemble_free(cube.scene, cube.body);
    VectorXd x(cube.inverse.size());
    Matrix3Xd small = Matrix3Xd::Zero(3, count);
    for (const std::int32_t node : cube.body.free_node)
        x.segment<3>(3 * cube.body.unknown[std::size_t(node)]) = small.col(node) = 1e-9 * way.col(node);
    (void)cube.hyper.energy(small, f);
    const VectorXd linear = (k * x).col(0);
    for (const std::int32_t node : cube.body.free_node)  // strains of 1e-7 a node: the next order is as much less
        EXPECT_WITHIN((f.col(node) - linear.segment<3>(3 * cube.body.unknown[std::size_t(node)])).norm(),
                      .epsilon = 1e-5, .size = linear.norm());
}

TEST(Indentation, ForceIsWhatTheStoredEnergyGrowsBy) {
    const StiffCube cube(5, 0.45, {5.0, 0.0, 0.0, {}});
    const Vector3d way = Vector3d(0.3, 0.1, -1.0).normalized();
    Indentation dent(cube.hyper, cube.inverse, cube.body.unknown, cube.finger(0.009).load);
    constexpr double kStep = 1e-5;
    std::array<double, 3> stored{};
    Vector3d force = Vector3d::Zero();
    for (int k = -1; k <= 1; ++k) {
        const auto felt = dent.force_n((0.006 + k * kStep) * way);
        ASSERT_TRUE(felt);
        stored[std::size_t(k + 1)] = dent.stored_j();
        if (k == 0) force = *felt;
    }
    // At rest to 1e-5 of the force; an energy's error is the square of that.
    EXPECT_WITHIN((stored[2] - stored[0]) / (2.0 * kStep) - force.dot(way), .epsilon = 1e-4, .size = force.norm());
    EXPECT_GT(force.dot(way), 1.3 * 0.006 * way.dot(dent.stiffness_n_per_m() * way)) << "it stiffens";
    const auto small = dent.force_n(1e-8 * way);
    ASSERT_TRUE(small);
    EXPECT_WITHIN((*small - 1e-8 * dent.stiffness_n_per_m() * way).norm(), .epsilon = 1e-4, .size = small->norm());
}

/// Dents that a curve makes, at four places of one direction each.
std::vector<Dent> dents_of(const StiffeningCurve& curve) {
    std::vector<Dent> dents;
    for (std::size_t place = 0; place < 4; ++place)
        for (int k = 1; k <= 6; ++k) {
            const double e = curve.energy_j * double(place + 1) / 4.0 * k * k / 36.0;
            dents.push_back({place, 0, 1e-3 * k, e, curve.factor(e), 0.0});
        }
    return dents;
}

TEST(StiffeningFit, GivesACurveBackAndNoneThatTurns) {
    const StiffeningCurve curve{{0.3, -0.2, 2.5}, 3e-3};
    const StiffeningCurve found = fit_curve(dents_of(curve), {true, false, false, false});
    EXPECT_NEAR(found.energy_j, curve.energy_j, 1e-12 * curve.energy_j);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found.c[k], curve.c[k], 1e-9);
    EXPECT_THROW((void)fit_curve(dents_of(curve), {false, true, true, true}), Error) << "no dent of these";
    // A body that collapses: its force falls from half of the way on.
    const StiffeningCurve falling{{0.0, -1.5, 0.0}, 3e-3};
    EXPECT_LT(falling.tangent(0.9 * falling.energy_j), 0.0);
    const StiffeningCurve held = fit_curve(dents_of(falling), {true, false, false, false});
    for (double part = 0.0; part < 1.5; part += 0.01) {
        EXPECT_GT(held.tangent(part * held.energy_j), 0.0) << part;
        EXPECT_GT(held.factor(part * held.energy_j), 0.0) << part;
    }
}

TEST(StiffeningCurve, StoredTangentAndEnergyAreOfItsForce) {
    const StiffeningCurve curve{{0.5, -0.5, 3.0}, 2e-4};
    constexpr double kSpring = 300.0, kStep = 1e-8;
    for (double d = 1e-5; d < 2.5e-3; d += 5e-5) {  // e_0 is at 1.15 mm
        const auto e = [&](double depth) { return 0.5 * kSpring * depth * depth; };
        const auto force = [&](double depth) { return curve.factor(e(depth)) * kSpring * depth; };
        EXPECT_NEAR((curve.stored(e(d + kStep)) - curve.stored(e(d - kStep))) / (2.0 * kStep), force(d),
                    1e-6 * force(d));
        EXPECT_NEAR((force(d + kStep) - force(d - kStep)) / (2.0 * kStep), curve.tangent(e(d)) * kSpring,
                    1e-5 * curve.tangent(e(d)) * kSpring);
        EXPECT_NEAR(curve.energy_at(force(d), kSpring), e(d), 1e-9 * e(d));
        EXPECT_GE(curve.largest_tangent(e(d)), curve.tangent(e(d)));
    }
    EXPECT_EQ(StiffeningCurve().factor(1.0), 1.0);
    EXPECT_EQ(StiffeningCurve().stored(1.0), 1.0);
}

// The paper's cube of 9 nodes a side and a finger tip: what a linear force misses is mostly given.
TEST(StiffeningFit, OfADentIsBetterThanLinearInEveryDirection) {
    StiffCube cube(7, 0.45, {5.0, 0.0, 0.0, {}});
    cube.scene.contact.grab = true;
    cube.scene.contact.static_friction = 0.5;
    const StiffeningFit fit = fit_stiffening(cube.scene, cube.body, {}, cube.inverse, cube.quiet);
    for (std::size_t way = 0; way < kDentWays.size(); ++way) {
        EXPECT_TRUE(fit.is_fitted[way]);
        EXPECT_GT(fit.by_way[way].dents, 20U);
        EXPECT_LT(fit.by_way[way].rms, 0.7 * fit.by_way[way].linear_rms) << kDentWays[way];
    }
    EXPECT_LT(fit.fitted.rms, 0.7 * fit.fitted.linear_rms);
    ASSERT_EQ(fit.good_m.size(), fit.by_place.size());
    for (std::size_t place = 0; place < fit.good_m.size(); ++place)
        EXPECT_LE(fit.good_m[place], fit.by_place[place].depth_m);
    EXPECT_LT(fit.good_m.front(), 0.7 * fit.good_m[2]) << "the first is beside the held base";
    EXPECT_GT(fit.good.pressing_m, 0.0);
    EXPECT_LE(fit.good.pressing_m, 0.3 * 0.03 * 1.000001);
    // A device of so little force never dents the body as deep.
    cube.scene.device.max_force_n = 1e-3;
    const StiffeningFit weak = fit_stiffening(cube.scene, cube.body, {}, cube.inverse, cube.quiet);
    EXPECT_LT(weak.by_way[0].depth_m, 0.01 * fit.by_way[0].depth_m);
    EXPECT_LT(weak.fitted.rms, 1e-3);
}

}  // namespace
}  // namespace haptable
