// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene may add to contact: friction, a soft release, passivity, a coupling. And that it costs nothing
// elsewhere.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

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

/// -sum of the nodal forces: the contact's own, N.
Vector3d contact_force(const Finger& finger) {
    Vector3d force = Vector3d::Zero();
    for (const auto& nodal : finger.out().nodal_force_n) force -= to_vector(nodal);
    return force;
}

// Whatever the finger does: it is never pushed where the contact does not push it, and never gets back more than it
// paid. A force times the motion that led to it gives no more than the way between, so the sum needs no stored energy.
TEST(Release, GivesNothingOnRandomWays) {
    const TestModel body(l_shape(6, 0.06), -1e9, GodObject::kLeastEnergy);
    haptable_model model = *body.get();
    model.release = haptable_release_slew;
    model.release_n = 0.02F;
    model.stiffness_limit_n_per_m = 400.0F;
    Finger finger(model);
    Wander wander(Vector3d::Constant(-0.01), Vector3d::Constant(0.07), 3e-4, 3);
    int released = 0, owing = 0;
    double given = 0.0, moved = 0.0;
    finger.to(wander.next());
    for (int tick = 0; tick < 30000; ++tick) {
        const Vector3d from = finger.at();
        finger.to(wander.next());
        const Vector3d step = finger.at() - from;
        const double pushes = std::max(0.0, contact_force(finger).dot(step));
        moved += finger.force().norm() * step.norm();
        ASSERT_WITHIN(finger.force().dot(step) - pushes, .count = 16, .epsilon = kFloat, .size = 8.5 * 0.07) << tick;
        given += finger.force().dot(step);
        ASSERT_WITHIN(given, .count = 64, .epsilon = kFloat, .size = moved) << tick;
        released += to_vector(finger.servo().released_n).norm() > 0.0;
        owing += finger.servo().owed_j > 0.0F;
    }
    EXPECT_GT(released, 100);
    EXPECT_GT(owing, 100);
    EXPECT_GT(finger.servo().counters.jumps, 10U);
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

TEST(Friction, TakesEnergyInClosedLoops) {
    const ElasticBody body(cube_scene(5, 0.3), ForceLaw::kConsistent);
    Finger finger(with_friction(body.model(GodObject::kLeastEnergy), 0.3F, 0.3F));
    std::mt19937 random(8);
    std::uniform_real_distribution<double> over(0.008, 0.022);
    for (int loop = 0; loop < 30; ++loop) {
        const Vector3d a(over(random), over(random), 0.031), b(over(random), over(random), 0.028);
        finger.begin();
        const Work work =
            walk(finger, {a, {a.x(), a.y(), 0.028}, b, {a.x(), b.y(), 0.0275}, {b.x(), b.y(), 0.031}}, 300);
        EXPECT_LT(work.given_j, -0.01 * work.put_in_j);
    }
}

/// Round and round on the cube with the paper's force, which gives energy in one sense: what the user got, J, of forces
/// that are held over a tick.
double circle(const haptable_model& model, double sense) {
    Finger finger(model);
    const Vector3d over(0.015, 0.015, 0.031), down(0, 0, -0.006), aside(sense * 0.0075, sense * 0.006, 0);
    double given = 0.0;
    for (int round = 0; round < 40; ++round)
        walk({over, over + down, over + down + aside, over + aside, over}, 150, [&](const Vector3d& x) {
            const Vector3d from = finger.at(), force = finger.force();
            finger.to(x);
            given += force.dot(finger.at() - from);
        });
    return given;
}

TEST(Passivity, TheControllerTakesBackWhatThePapersForceGives) {
    const ElasticBody body(cube_scene(5, 0.3), ForceLaw::kInterpolated);
    haptable_model model = body.model();
    const double without = std::max(circle(model, 1.0), circle(model, -1.0));
    model.passivity = haptable_passivity_control;
    const double with = std::max(circle(model, 1.0), circle(model, -1.0));
    EXPECT_GT(without, 1e-3);
    EXPECT_WITHIN(with, .epsilon = 0.02, .size = without);
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
