// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene may add to contact: friction, a soft release, a coupling. And that it costs nothing
// elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

struct EdgeRun {
    double largest_drop = 0.0, given = 0.0;
    int ticks_of_release = 0;
};

/// Presses 3 mm deep and slides out over the convex edge of the top, 0.05 mm a tick.
EdgeRun leave_over_edge(const haptable_model& model) {
    Finger finger(model);
    finger.to({0.02, 0.015, 0.031});
    for (int i = 0; i <= 60; ++i) finger.to({0.02, 0.015, 0.030 - 5e-5 * i});
    EdgeRun run;
    for (int i = 1; i <= 400; ++i) {
        const Vector3d before = finger.force(), from = finger.at();
        finger.to({0.02 + 5e-5 * i, 0.015, 0.027});
        run.largest_drop = std::max(run.largest_drop, (finger.force() - before).norm());
        if (finger.touches()) continue;
        run.ticks_of_release += finger.force().norm() > 0.0;
        run.given += finger.force().dot(finger.at() - from);
    }
    return run;
}

TEST(Release, AForceThatEndsAtAConvexEdgeIsBroughtDownAtItsSlew) {
    const SpringBox box;
    haptable_model model = box.model();
    EXPECT_GT(leave_over_edge(model).largest_drop, 1.4) << "1.5 N at once: the click";
    model.release = haptable_release_slew;
    model.release_n = 0.05F;
    model.stiffness_limit_n_per_m = 5000.0F;  // another part of the body may be as stiff as that
    const EdgeRun run = leave_over_edge(model);
    const double drop_n = 0.05 + 500.0 * 5e-5;  // of the release, and of the spring
    EXPECT_WITHIN(run.largest_drop - drop_n, .count = 64, .epsilon = kFloat, .size = 500.0 * 0.03);
    EXPECT_WITHIN(run.given, .count = 64, .epsilon = kFloat, .size = 1.5 * 5e-5) << "it only dissipates";
    EXPECT_GE(run.ticks_of_release, 27);
    EXPECT_LE(run.ticks_of_release, 31);
}

/// A finger that is pressed so deep into a spring of 1,000 N/m at the most, by a release of 0.01 N a tick alone.
struct PressedSpring {
    explicit PressedSpring(double depth) : depth_m(depth) {
        model.release_n = 0.01F;
        model.stiffness_limit_n_per_m = 1000.0F;
        haptable_servo_init(&servo);
        servo.contact.patch = 0;
    }
    /// The force outwards that is given; the contact's own is contact_n.
    double move(double motion_m, double contact_n, double aside_m = 0.0) {
        depth_m += motion_m;
        const float motion[3] = {static_cast<float>(motion_m), static_cast<float>(aside_m), 0.0F};
        float force_n[3] = {static_cast<float>(-contact_n), 0.0F, 0.0F};
        servo.finger_m[0] = static_cast<float>(depth_m);
        haptable_release_slew(&model, &servo, motion, force_n);
        return -double(force_n[0]);
    }
    /// It felt that, and so much of another force is being released; outwards.
    void felt(double force_n, double released_n) {
        servo.felt_known = 1;
        servo.felt_n[0] = static_cast<float>(-force_n);
        servo.released_n[0] = static_cast<float>(-released_n);
    }

    const TestModel body{box_shape(2, Vector3d(0.03, 0.03, 0.03))};
    haptable_model model = *body.get();
    haptable_room room{};
    haptable_servo& servo = room.fingers.servo[0];
    double depth_m;
};

// A jump from 0.1 N to 0.5 N: the finger feels 0.01 N more a tick. What it has not paid holds back what pushes it out.
TEST(Release, AForceThatBrakesMoreComesUpAtItsSlewAndIsPaid) {
    PressedSpring finger(1e-3);
    for (int tick = 0; tick < 20; ++tick) finger.move(0.0, 0.1);  // whatever it began with is gone
    constexpr double kWay = 1e-6;
    const Bound rounded{.count = 64, .epsilon = kFloat, .size = 0.5};
    double owed = 0.0;
    for (int tick = 1; tick <= 10; ++tick) {
        const double force = finger.move(kWay, 0.5);
        EXPECT_WITHIN(std::abs(force - (0.1 + 0.01 * tick)), rounded) << tick;
        owed += kWay * (0.5 - force);
    }
    EXPECT_EQ(finger.servo.counters.jumps, 2U) << "the first contact's and this one";
    EXPECT_WITHIN(std::abs(double(finger.servo.owed_j) - owed), .count = 64, .epsilon = kFloat, .size = owed);
    double paid = 0.0;
    while (finger.servo.owed_j > 0.0F) {
        const double force = finger.move(-kWay, 0.5);  // out again: nothing pushes
        ASSERT_LT(paid, owed);
        if (finger.servo.owed_j > 0.0F) {
            EXPECT_WITHIN(std::abs(force), rounded);
        }
        paid += kWay * (0.5 - force);
    }
    EXPECT_WITHIN(owed - paid, .count = 256, .epsilon = kFloat, .size = owed);
    EXPECT_LT(paid - owed, kWay * 0.5) << "no more than a tick too much";
    double last = finger.move(-kWay, 0.5);
    for (int tick = 0; tick < 60; ++tick) {  // then it comes up again, by the slew
        const double force = finger.move(-kWay, 0.5);
        EXPECT_LE(force - last, 0.01 + 1e-6);
        last = force;
    }
    EXPECT_WITHIN(std::abs(last - 0.5), rounded);
}

// As it does where it leaves the surface: the finger has come to the god-object.
TEST(Release, AForceThatEndsOnTheSurfaceIsReleased) {
    PressedSpring finger(0.0);
    finger.felt(0.5, 0.0);
    EXPECT_WITHIN(std::abs(finger.move(0.0, 0.0, 1e-3) - 0.49), .count = 8, .epsilon = kFloat, .size = 0.5);
    EXPECT_EQ(finger.servo.counters.jumps, 1U);
}

// What the finger pays over a long motion is known to first order: with a force held back that would take it, more than
// the contact stores must not be owed.
TEST(Release, NoMoreIsHeldBackThanIsStored) {
    PressedSpring finger(-2e-4);
    finger.felt(0.06, -0.5);  // of a force that has ended; now it would push
    finger.move(1.2e-3, 0.72);
    const double stored = 0.5 * 0.72 * 1e-3;
    EXPECT_EQ(finger.servo.counters.jumps, 0U);
    for (const double held_j : {double(finger.servo.owed_j), double(finger.servo.released_n[0]) * 1.2e-3})
        EXPECT_WITHIN(std::abs(held_j - stored), .count = 32, .epsilon = kFloat, .size = stored);
}

TEST(Friction, SticksWithinTheStaticConeAndSlipsOnTheKineticOne) {
    const SpringBox box;
    Finger finger(with_friction(box.model(), 0.4F, 0.3F));
    finger.to({0.010, 0.012, 0.031});
    for (int i = 0; i <= 40; ++i) finger.to({0.010, 0.012, 0.030 - 5e-5 * i});
    const Vector3d stuck = finger.god();
    const Bound position{.count = 32, .epsilon = kFloat, .size = 0.03};
    bool slipped = false;
    for (int i = 1; i <= 200; ++i) {
        const double aside = 2e-5 * i;  // 2 mm deep: slips from 0.8 mm on
        finger.to({0.010 + aside, 0.012, 0.028});
        ASSERT_TRUE(finger.touches());
        const Vector3d f = finger.force();
        const double ratio = f.head<2>().norm() / f.z();
        if (aside < 0.000795) {
            EXPECT_WITHIN((finger.god() - stuck).norm(), position) << i;
            // Depth and way are differences of positions.
            EXPECT_WITHIN(std::abs(ratio - aside / 0.002), position.times(2.0 / 0.002));
        }
        if (aside > 0.00083) {
            slipped = true;
            EXPECT_GT(ratio, 0.29);
            EXPECT_WITHIN(ratio - 0.3, position.times(2.0 / 0.002)) << i;
        }
    }
    EXPECT_TRUE(slipped);
    const Vector3d before = finger.god();
    finger.to({0.01395, 0.012, 0.028});  // a little back: it sticks again
    EXPECT_WITHIN((finger.god() - before).norm(), position);
}

// A contact that a refused position has ended is not gone on with, neither where the god-object was held nor where it
// would be without friction: the finger is inside then, and nobody knows how it came there.
TEST(Friction, AnEndedContactLeavesNothing) {
    const ElasticBody body(cube_scene(5, 0.3), ForceLaw::kInterpolated);
    for (const GodObject god_object : every<GodObject>()) {
        Finger finger(with_friction(body.model(god_object)));
        for (int i = 0; i < 60; ++i) finger.to({0.006 + 5e-5 * i, 0.006, 0.031 - 5e-5 * i});
        EXPECT_TRUE(finger.touches());
        finger.to(Vector3d::Constant(std::nan("")));
        for (int i = 0; i < 5; ++i) {
            finger.to({0.022, 0.021, 0.029 - 4e-5 * i});
            EXPECT_FALSE(finger.touches()) << i;
            EXPECT_EQ(finger.force(), Vector3d::Zero()) << i;
        }
    }
}

// What the device renders, and no softer than needed. A body feels motion scale x force scale as stiff to the hand, and
// a force that comes late gives more energy.
TEST(Coupling, AutoLeavesNoPointStifferThanTheDeviceRenders) {
    const auto felt = [](Scene scene, ForceLaw force, double stable_n_per_m) {
        scene.contact.auto_coupling = true;
        const ElasticBody body(scene, force, 0.008);
        const ServoStiffness& k = body.servo().stiffness;
        EXPECT_WITHIN(std::abs(k.stable_n_per_m - stable_n_per_m), .count = 16, .size = stable_n_per_m);
        EXPECT_GT(k.largest_n_per_m, k.stable_n_per_m) << "the test must need a coupling";
        EXPECT_WITHIN(k.felt_n_per_m / k.stable_n_per_m - 1.0, .count = 64, .epsilon = kFloat) << force;
        EXPECT_WITHIN(1.0 - k.felt_n_per_m / k.stable_n_per_m, .epsilon = 1e-2) << force;
        return double(body.model().max_force_n);
    };
    for (const ForceLaw force : every<ForceLaw>()) felt(cube_scene(5, 0.49), force, 2 * 0.005 / 1e-3 + 2 * 0.04 / 5e-4);
    Scene scaled = cube_scene(4, 0.3);
    scaled.device_map.motion_scale = 0.5;
    scaled.device_map.force_scale = 8.0;
    scaled.device.delay_s = 1e-3;
    const double most_n = felt(scaled, ForceLaw::kConsistent, (0.005 + 0.04 / 0.5) / (0.5e-3 + 1e-3) / 4.0);
    EXPECT_WITHIN(std::abs(most_n - 8.5 / 8.0), .count = 4, .epsilon = kFloat, .size = 8.5 / 8.0);
}

}  // namespace
}  // namespace haptable::test
