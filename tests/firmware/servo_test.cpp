// SPDX-License-Identifier: GPL-2.0-or-later
// Force and safety of one tick, through the public header.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/bodies.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

class ServoTest : public testing::Test {
protected:
    void press(double depth) {
        finger.to({0.0131, 0.0172, 0.031});
        finger.to({0.0131, 0.0172, 0.030 - depth});
    }
    void expect_silent_output() const {
        EXPECT_EQ(finger.force().norm(), 0.0);
        EXPECT_EQ(finger.out().patch, HAPTABLE_NONE);
        for (const auto& nodal : finger.out().nodal_force_n) EXPECT_EQ(to_vector(nodal).norm(), 0.0);
    }

    const TestModel model{box_shape(4, Vector3d(0.03, 0.03, 0.03)), 0.001};
    Finger finger{model};
};

// Equations 9 to 12 in double, from the output's own patch, area coordinates and god-object.
TEST_F(ServoTest, ForceIsThatOfEquations9To12) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> over(0.0, 0.03), deep(0.0, 0.004);
    for (int i = 0; i < 2000; ++i) {
        finger.begin();
        const Vector3d x(over(random), over(random), 0.030 - deep(random));
        finger.to({x.x(), x.y(), 0.032});
        const haptable_output& out = finger.to(x);
        if (out.state != HAPTABLE_CONTACT) continue;
        const Vector3d u = finger.at() - finger.god();
        Vector3d force = Vector3d::Zero();
        double size = 0.0;
        for (int c = 0; c < 3; ++c) {
            const Vector3d nodal = double(out.alpha[c]) * (model.stiffness(out.vertex[c]) * u);
            EXPECT_WITHIN((nodal - to_vector(out.nodal_force_n[c])).norm(), .count = 16, .epsilon = kFloat,
                          .size = double(out.alpha[c]) * model.stiffness(out.vertex[c]).norm() * u.norm() + 1e-12);
            force -= nodal;
            size += nodal.norm();
        }
        if (force.norm() < 8.0) {
            EXPECT_WITHIN((force - finger.force()).norm(), .count = 16, .epsilon = kFloat, .size = size);
        }
    }
}

/// Force of every tick with the finger at x, until there has been none for a while.
std::vector<double> force_at(Finger& finger, const Vector3d& x) {
    std::vector<double> force_n;
    for (int tick = 0; tick < 60; ++tick) {
        finger.to(x);
        force_n.push_back(finger.force().norm());
    }
    return force_n;
}

// Through the body and out of its other side, which nothing may touch: the god-object is left behind on the top. Where
// the finger is farther from it than the body's diagonal, its force falls to zero over HAPTABLE_FADE_TICKS.
TEST_F(ServoTest, AGodObjectThatIsLeftFarBehindLetsGoByARelease) {
    press(0.002);
    const std::vector<double> force_n = force_at(finger, {0.0131, 0.0172, 0.030 - 0.3});
    const double most_n = double(model.get()->max_force_n);
    EXPECT_WITHIN(std::abs(force_n.front() - most_n), .count = 8, .epsilon = kFloat, .size = most_n);
    for (std::size_t i = 1; i < force_n.size(); ++i) {
        EXPECT_LE(force_n[i], force_n[i - 1]);
        EXPECT_GE(force_n[i], force_n[i - 1] - 1.01 * most_n / HAPTABLE_FADE_TICKS) << "a jump";
    }
    EXPECT_EQ(finger.counters().given_up, 1U);
    expect_silent_output();
    press(0.001);
    EXPECT_TRUE(finger.touches()) << "it may touch again";
}

// Less far than the body is large it stays, and its force with it.
TEST_F(ServoTest, AGodObjectThatIsNearKeepsItsForce) {
    press(0.002);
    const double diagonal_m = std::sqrt(3.0) * 0.03;
    const std::vector<double> force_n = force_at(finger, {0.0131, 0.0172, 0.030 - 0.99 * diagonal_m});
    EXPECT_EQ(force_n.front(), force_n.back());
    EXPECT_EQ(finger.counters().given_up, 0U);
}

TEST_F(ServoTest, SilenceBringsTheForceToZero) {
    haptable_output out{};
    EXPECT_EQ(haptable_servo_watch(&finger.servo(), 0, &out), 1) << "no position yet";
    constexpr std::uint32_t kStart_us = 0xFFFFFFFFU - 1500, kNow_us = kStart_us + 2000;  // the clock wraps
    finger.to({0.0131, 0.0172, 0.032}, kStart_us);
    press(0.001);
    EXPECT_EQ(haptable_servo_watch(&finger.servo(), kNow_us + HAPTABLE_SILENCE_US - 1, &out), 0);
    EXPECT_TRUE(finger.touches());
    for (const std::uint32_t later_us : {HAPTABLE_SILENCE_US, 10 * HAPTABLE_SILENCE_US}) {
        EXPECT_EQ(haptable_servo_watch(&finger.servo(), kNow_us + later_us, &out), 1);
        EXPECT_EQ(out.state, HAPTABLE_SILENT);
        EXPECT_EQ(out.patch, HAPTABLE_NONE);
        EXPECT_EQ(to_vector(out.force_n).norm(), 0.0);
        EXPECT_EQ(finger.counters().silences, 1U) << "one silence is counted once";
    }
    press(0.001);
    EXPECT_TRUE(finger.touches());
}

// All of it is a plain scene's too: what a mode remembers for itself stands beside its model.
TEST(Servo, StateIsSmall) {
    EXPECT_LE(sizeof(haptable_servo), 304U);
    EXPECT_LE(offsetof(haptable_servo, nearest_m2), 240U) << "in the paper's mode";
}

// ---- from tick to tick: no step of the algorithm's own --------------------------------------------------------------

/// Forces of a finger that slides 18 mm over the cube's top at 100 mm/s, every `share` of a millisecond; [N].
struct Slide {
    std::vector<Vector3d> force;
    double stiffness = 0.0;  // N/m, normal, mean

    /// Largest change of the tangential force from one to the next, in units of k v dt.
    double worst_tangential() const {
        double worst = 0.0;
        for (std::size_t i = 1; i < force.size(); ++i)
            worst = std::max(worst, (force[i] - force[i - 1]).head<2>().norm());
        return worst / (stiffness * 1.044e-4);
    }
};

Slide slide(const haptable_model& model, double depth_m, int ticks_per_ms = 1) {
    Finger finger(model);
    const Vector3d begin(0.006, 0.011, 0.03 - depth_m);
    for (int i = 100; i >= 0; --i) finger.to(begin + Vector3d(0, 0, depth_m * i / 99.0));
    Slide result;
    for (int i = 0; i <= 180 * ticks_per_ms; ++i) {
        finger.to(begin + double(i) / ticks_per_ms * Vector3d(1e-4, 0.3e-4, 0));
        EXPECT_TRUE(finger.touches());
        if (i % ticks_per_ms == 0) result.force.push_back(finger.force());
    }
    for (const Vector3d& f : result.force) result.stiffness += f.z() / depth_m / double(result.force.size());
    return result;
}

// The god-object has settled when a tick ends: had the servo ticked twenty times as often, the force would be the same.
TEST(Continuity, NothingSettlesOverSeveralTicks) {
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god : every<GodObject>()) {
            const ElasticBody body(cube_scene(5, 0.3), force, 0.012);
            const Slide coarse = slide(body.model(god), 0.002), fine = slide(body.model(god), 0.002, 20);
            double worst = 0.0;
            for (std::size_t i = 0; i < coarse.force.size(); ++i)
                worst = std::max(worst, (coarse.force[i] - fine.force[i]).norm() / fine.force[i].norm());
            // A walk ends within 2^-20 of the size.
            EXPECT_WITHIN(worst, .count = 4, .epsilon = 0x1p-20, .condition = body.size() / 0.002)
                << force << " " << god;
        }
}

// A finger that stays where it is feels one force to the last bit: nothing alternates from tick to tick.
TEST(Continuity, AFingerAtRestFeelsTheSameBits) {
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god : every<GodObject>()) {
            const ElasticBody body(cube_scene(5, 0.3), force, 0.012);
            std::mt19937 random(3);
            std::uniform_real_distribution<double> over(0.004, 0.026), deep(0.0002, 0.003);
            for (int press = 0; press < 100; ++press) {
                Finger finger(body.model(god));
                const Vector3d above(over(random), over(random), 0.0301),
                    in(above.x() + 2e-4, above.y(), 0.03 - deep(random));
                walk(finger, {above, in}, 20);
                for (int tick = 0; tick < 4; ++tick) finger.to(in);
                EXPECT_TRUE(finger.touches());
                const haptable_output rested = finger.out();
                for (int tick = 0; tick < 20; ++tick) {
                    finger.to(in);
                    ASSERT_EQ(finger.force(), to_vector(rested.force_n)) << force << " " << god;
                    ASSERT_EQ(to_vector(finger.out().alpha), to_vector(rested.alpha)) << force << " " << god;
                }
            }
        }
}

// 1 mm deep on a mesh of 9 nodes a side and, for the mask, a radius of two edges; deeper and coarser: docs/CONTACT.md.
TEST(Continuity, SlidingUnderTheNearestGodObjectIsSmooth) {
    for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kPressureMask}) {
        const ElasticBody body(cube_scene(9, 0.3), force, 0.0075);
        const double worst = slide(body.model(GodObject::kNearest), 0.001).worst_tangential();
        // The stiffness changes by less than half of itself over an edge.
        EXPECT_WITHIN(worst, .count = 0.5, .epsilon = 0.001 / 0.00375) << force;
    }
}

}  // namespace
}  // namespace haptable::test
