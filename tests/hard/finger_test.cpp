// SPDX-License-Identifier: GPL-2.0-or-later
// A finger where coordinates meet: exactly on vertices, edges and patches, at the body's centre, at subnormal
// distances, and where no finger can be.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "codegen/in_memory.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 0.03;
const Vector3d kCentre(0.0, 0.0, -0.5 * kSide);

/// A cube whose top's middle is the origin, and a vertex: distances there may be as small as a float can be.
Cells cube_under_the_origin() {
    return {{4, 4, 4},
            [](double a, double b, double c) { return Vector3d(kSide * Vector3d(a - 0.5, b - 0.5, c - 1.0)); },
            [](int, int, int) { return true; },
            [](const Vector3d& x) { return x.z() < -kSide + 1e-9; }};
}

bool is_whole(const haptable_output& out) {
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) {
        sum += double(out.force_n[c]) + double(out.god_object_m[c]) + double(out.alpha[c]);
        for (const auto& nodal : out.nodal_force_n) sum += double(nodal[c]);
    }
    return std::isfinite(sum);
}

class HardFinger : public testing::TestWithParam<std::tuple<ForceLaw, GodObject>> {
protected:
    static const ElasticBody& body(ForceLaw force) {
        static const ElasticBody interpolated(cube_under_the_origin(), "hard", ForceLaw::kInterpolated),
            consistent(cube_under_the_origin(), "hard", ForceLaw::kConsistent),
            mask(cube_under_the_origin(), "hard", ForceLaw::kPressureMask, 0.012);
        return force == ForceLaw::kInterpolated ? interpolated : force == ForceLaw::kConsistent ? consistent : mask;
    }
    const ElasticBody& cube = body(std::get<0>(GetParam()));
    const haptable_model model = cube.model(std::get<1>(GetParam()));
    /// The largest stiffness of any point, N/m.
    const double stiffness = cube.servo().stiffness.largest_n_per_m;

    /// Every corner, the middle of every edge, the centroid and a point of every patch, as floats can hold them.
    std::vector<Vector3d> places() const {
        std::vector<Vector3d> places;
        for (int p = 0; p < cube.patches(); ++p)
            for (const Vector3d& alpha :
                 {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(0.5, 0.5, 0), Vector3d(0, 0.5, 0.5),
                  Vector3d(0.5, 0, 0.5), Vector3d(0.25, 0.25, 0.5), Vector3d(1 / 3., 1 / 3., 1 / 3.)})
                places.push_back(cube.point(p, alpha).cast<float>().cast<double>());
        return places;
    }
};

INSTANTIATE_TEST_SUITE_P(Modes, HardFinger,
                         testing::Combine(testing::ValuesIn(every<ForceLaw>()),
                                          testing::Values(GodObject::kNearest, GodObject::kLeastEnergy)),
                         [](const auto& mode) {
                             return test_name(std::string(word(std::get<0>(mode.param))) + " " +
                                              word(std::get<1>(mode.param)));
                         });

// Whether a point of the surface is inside is a matter of rounding; the force there is not: a finger on the surface is
// at most a tolerance deep. From there it goes in, is felt, and goes out again.
TEST_P(HardFinger, ExactlyOnVerticesEdgesAndPatches) {
    const double tolerance = double(model.tolerance_m), depth = 0.002;
    int count = 0;
    for (const Vector3d& on : places()) {
        const Vector3d out = (on - kCentre).normalized();  // along a face that meets another there is not inside
        Finger finger(model);
        ASSERT_TRUE(is_whole(finger.to(on)));
        EXPECT_FALSE(finger.touches()) << "a first position is nowhere inside";
        for (const Vector3d& from : {Vector3d(on + depth * out), on}) {
            finger.begin();
            ASSERT_TRUE(is_whole(finger.to(from)));
            for (int tick = 0; tick < 3; ++tick) {
                ASSERT_TRUE(is_whole(finger.to(on)));
                EXPECT_WITHIN(finger.force().norm(), .count = 4, .epsilon = 1.0, .size = stiffness * tolerance)
                    << on.transpose();
            }
        }
        finger.begin();
        finger.to(on + depth * out);
        finger.to(on);
        ASSERT_TRUE(is_whole(finger.to(on - depth * out)));
        ++count;
        EXPECT_TRUE(finger.touches()) << on.transpose();
        EXPECT_GT(finger.energy(), 0.0) << on.transpose();
        ASSERT_TRUE(is_whole(finger.to(on)));
        ASSERT_TRUE(is_whole(finger.to(on + 2 * tolerance * out)));
        ASSERT_TRUE(is_whole(finger.to(on + depth * out)));
        EXPECT_FALSE(finger.touches()) << on.transpose();
        EXPECT_EQ(finger.force().norm(), 0.0);
    }
    EXPECT_GT(count, 1000);
}

// The nearest point of the surface is not one point there.
TEST_P(HardFinger, AtTheBodysCentre) {
    Finger finger(model);
    ASSERT_TRUE(is_whole(finger.to(kCentre)));
    EXPECT_EQ(finger.force().norm(), 0.0) << "nobody knows how it came there: it is not thrown out";
    finger.begin();
    for (int mm = 2; mm >= -15; --mm) ASSERT_TRUE(is_whole(finger.to({0.0, 0.0, 1e-3 * mm})));
    ASSERT_TRUE(finger.touches());
    const double force = finger.force().norm();
    EXPECT_GT(force, 0.0);
    for (int tick = 0; tick < 100; ++tick) {
        ASSERT_TRUE(is_whole(finger.to(kCentre)));
        ASSERT_TRUE(finger.touches());
        if (std::get<1>(GetParam()) == GodObject::kNearest) {
            EXPECT_EQ(finger.force().norm(), force) << "it rests";
        }
    }
    EXPECT_LE(finger.force().norm(), force * (1.0 + 4 * kFloat)) << "energy only falls";
}

// 1e30 m is a number whose square is none; the position after it is a first one.
TEST_P(HardFinger, WhereNoFingerCanBe) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    std::uint32_t rejected = 0;
    for (const double far : {50.0, 1e30, -1e30, 3e38, kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN()})
        for (int axis = 0; axis < 3; ++axis) {
            Finger finger(model);
            finger.to({0.001, 0.002, 0.001});
            finger.to({0.001, 0.002, -0.001});
            ASSERT_TRUE(finger.touches());
            Vector3d x(0.001, 0.002, -0.001);
            x[axis] = far;
            ASSERT_TRUE(is_whole(finger.to(x)));
            EXPECT_EQ(finger.out().state, HAPTABLE_REJECTED);
            EXPECT_EQ(finger.out().patch, HAPTABLE_NONE);
            EXPECT_EQ(finger.force().norm(), 0.0);
            rejected += finger.counters().rejected_positions;
            ASSERT_TRUE(is_whole(finger.to({0.001, 0.002, -0.001})));
            EXPECT_FALSE(finger.touches()) << "what is inside after a gap was not pressed";
            finger.to({0.001, 0.002, 0.001});
            finger.to({0.001, 0.002, -0.001});
            EXPECT_TRUE(finger.touches());
        }
    EXPECT_EQ(rejected, 21U);
}

// The origin is a vertex of the top: products of such distances are subnormal or zero.
void expect_whole_at_subnormal_distances(const haptable_model& model, double stiffness) {
    for (const double tiny : {1e-45, 1e-42, 1e-40, 1e-38, 1e-30, 1e-20, 1e-15, 1e-12}) {
        const double held = double(static_cast<float>(tiny));
        for (const Vector3d& way : {Vector3d(0, 0, -1), Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(1, 1, -1),
                                    Vector3d(-1, 1, 1), Vector3d(1, 0, -1)}) {
            Finger finger(model);
            finger.to({0.0, 0.0, 0.001});
            ASSERT_TRUE(is_whole(finger.to(held * way))) << tiny << " " << way.transpose();
            EXPECT_WITHIN(finger.force().norm(), .count = 4, .epsilon = 1.0,
                          .size = stiffness * (double(model.tolerance_m) + held));
            for (int tick = 0; tick < 10; ++tick)
                ASSERT_TRUE(is_whole(finger.to((tick % 2 == 0 ? -1 : 1) * held * way)));
            finger.to({0.0, 0.0, -0.001});
            ASSERT_TRUE(finger.touches());
            for (int tick = 0; tick < 10; ++tick)  // a finger that moves by less than its coordinates hold
                ASSERT_TRUE(is_whole(finger.to(Vector3d(0.0, 0.0, -0.001) + (tick % 2 == 0 ? -1 : 1) * held * way)));
            EXPECT_GT(finger.force().z(), 0.0);
            for (int tick = 0; tick < 10; ++tick)  // out in one tick: what it was given is owed
                ASSERT_TRUE(is_whole(finger.to((tick % 2 == 0 ? -1 : 1) * held * way)));
            EXPECT_EQ(finger.counters().rejected_forces, 0U) << tiny << " " << way.transpose();
        }
    }
}

TEST_P(HardFinger, AtASubnormalDistance) { expect_whole_at_subnormal_distances(model, stiffness); }

// What is divided by there is of what a scene may add: friction, release, passivity, relaxation and limits.
TEST_P(HardFinger, AtASubnormalDistanceWithAllThatMayBeAdded) {
    Tables tables = cube.tables();
    tables.god_object = std::get<1>(GetParam());
    tables.static_friction = 0.5;
    tables.kinetic_friction = 0.4;
    tables.options.set("contact.release_slew", 0.01);
    tables.options.set("contact.passivity", true);
    tables.relaxation = {{0.3, 0.01}};
    tables.limits.max_force_rate_n_per_s = 1e4;
    tables.limits.mean_force_n = 5.0;
    const ServoModel servo = build_model(tables);
    expect_whole_at_subnormal_distances(model_in_memory(tables, servo), stiffness);
}

}  // namespace
}  // namespace haptable::test
