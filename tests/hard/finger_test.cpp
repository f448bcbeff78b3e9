// SPDX-License-Identifier: GPL-2.0-or-later
// A finger where coordinates meet: exactly on vertices, edges and patches, at the body's centre, at subnormal
// distances, over a tip of many patches, through a plate, and where no finger can be.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "codegen/in_memory.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/shapes.hpp"

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

/// Whether all that a tick gives are numbers.
bool is_whole(const haptable_output& out) {
    double sum = (to_vector(out.force_n) + to_vector(out.god_object_m) + to_vector(out.alpha)).sum();
    for (const auto& nodal : out.nodal_force_n) sum += to_vector(nodal).sum();
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
    for (const double tiny : {1e-45, 1e-42, 1e-40, 1e-38, 1e-30, 1e-20, 1e-15, 1e-12})
        for (const Vector3d& way : {Vector3d(0, 0, -1), Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(1, 1, -1),
                                    Vector3d(-1, 1, 1), Vector3d(1, 0, -1)}) {
            SCOPED_TRACE(testing::Message() << tiny << " " << way.transpose());
            const double held = double(static_cast<float>(tiny));
            Finger finger(model);
            const auto tremble = [&](const Vector3d& about) {
                for (int tick = 0; tick < 10; ++tick)
                    ASSERT_TRUE(is_whole(finger.to(about + (tick % 2 == 0 ? -1 : 1) * held * way)));
            };
            finger.to({0.0, 0.0, 0.001});
            ASSERT_TRUE(is_whole(finger.to(held * way)));
            EXPECT_WITHIN(finger.force().norm(), .count = 4, .epsilon = 1.0,
                          .size = stiffness * (double(model.tolerance_m) + held));
            tremble(Vector3d::Zero());
            finger.to({0.0, 0.0, -0.001});
            ASSERT_TRUE(finger.touches());
            tremble({0.0, 0.0, -0.001});  // a finger that moves by less than its coordinates hold
            EXPECT_GT(finger.force().z(), 0.0);
            tremble(Vector3d::Zero());  // out in one tick: what it was given is owed
            EXPECT_EQ(finger.counters().rejected_forces, 0U);
        }
}

TEST_P(HardFinger, AtASubnormalDistance) { expect_whole_at_subnormal_distances(model, stiffness); }

// What is divided by there is of what a scene may add: friction, release, passivity, relaxation and limits.
TEST_P(HardFinger, AtASubnormalDistanceWithAllThatMayBeAdded) {
    Tables tables = cube.tables({.god_object = std::get<1>(GetParam()),
                                 .friction = 0.4,
                                 .passivity = true,
                                 .max_force_n = cube.tables().max_force_n,
                                 .limits = {.max_force_rate_n_per_s = 1e4, .mean_force_n = 5.0}});
    tables.static_friction = 0.5;
    tables.options.set("contact.release_slew", 0.01);
    tables.relaxation = {{0.3, 0.01}};
    const ServoModel servo = build_model(tables);
    expect_whole_at_subnormal_distances(model_in_memory(tables, servo), stiffness);
}

// A plate is thinner than a finger presses: what holds the finger is the face that it came through, not the nearest
// one.
TEST(HardSlender, AFingerThatIsPushedThroughAPlateStaysOnTheFaceThatItEntered) {
    const ElasticBody plate(plate_cells(6, 0.1, 0.001), "plate", ForceLaw::kInterpolated);
    constexpr double kTop = 0.001, kDeepest = 0.004;
    for (const GodObject god_object : every<GodObject>()) {
        Finger finger(plate.model(god_object));
        double last = 0.0;
        for (int tick = -5; tick <= 40; ++tick) {
            finger.to({0.0503, 0.0487, kTop - 1e-4 * tick});
            if (tick < 1) continue;
            ASSERT_TRUE(finger.touches()) << word(god_object) << " " << 0.1 * tick << " mm";
            EXPECT_WITHIN(std::abs(finger.god().z() - kTop), .count = 4, .epsilon = kFloat, .size = kDeepest);
            EXPECT_GT(finger.force().z(), last) << "deeper is harder";
            last = finger.force().z();
        }
    }
}

// The tip is the nearest point of the surface, and some of its patches say "outside" and others "inside": all of them
// have to be asked, from whichever the contact comes.
TEST(HardHub, AFingerThatLeavesOverATipOfThirtyTwoPatchesIsLetGo) {
    constexpr int kSides = HAPTABLE_FAN_PATCHES;
    const TestModel tip(spindle_shape(kSides, 0.005, 0.03));
    const auto at = [&](double side, double radius, double z) {
        const double turn = 2.0 * std::numbers::pi * (side + 0.5) / kSides;
        return Vector3d(radius * std::cos(turn), radius * std::sin(turn), z);
    };
    Finger finger(tip);
    for (int from = 0; from < kSides; from += 5)
        for (int to = 0; to < 2 * kSides; ++to) {  // over patches and over the edges between them
            finger.begin();
            finger.to(at(from, 0.002, 0.028));
            finger.to(at(from, 0.0002, 0.028));
            ASSERT_TRUE(finger.touches()) << from;
            finger.to(at(0.5 * to, 0.0005, 0.0301));
            EXPECT_FALSE(finger.touches()) << "from patch " << from << " to patch " << 0.5 * to;
        }
}

}  // namespace
}  // namespace haptable::test
