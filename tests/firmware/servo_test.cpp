// SPDX-License-Identifier: GPL-2.0-or-later
// Force and safety of one tick, through the public header.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "tests/finger.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

class ServoTest : public testing::Test {
protected:
    ServoTest() : model(box_shape(4, Vector3d(0.03, 0.03, 0.03)), 0.001) { haptable_servo_init(&servo); }

    void step(const Vector3d& x) {
        const float finger[3] = {float(x.x()), float(x.y()), float(x.z())};
        haptable_servo_step(model.get(), &servo, finger, now_us += 1000, &out);
    }
    void press(double depth) {
        step({0.0131, 0.0172, 0.031});
        step({0.0131, 0.0172, 0.030 - depth});
    }
    void expect_silent_output() const {
        EXPECT_EQ(to_vector(out.force_n).norm(), 0.0);
        EXPECT_EQ(out.patch, HAPTABLE_NONE);
        for (const auto& nodal : out.nodal_force_n) EXPECT_EQ(to_vector(nodal).norm(), 0.0);
    }

    TestModel model;
    haptable_servo servo{};
    haptable_output out{};
    std::uint32_t now_us = 0;
};

// Equations 9 to 12 in double, from the output's own patch, area coordinates and god-object.
TEST_F(ServoTest, ForceIsThatOfEquations9To12) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> over(0.0, 0.03), deep(0.0, 0.004);
    for (int i = 0; i < 2000; ++i) {
        haptable_servo_init(&servo);
        const double x = over(random), y = over(random), depth = deep(random);
        step({x, y, 0.032});
        step({x, y, 0.030 - depth});
        if (out.state != HAPTABLE_CONTACT) continue;
        const float finger[3] = {float(x), float(y), float(0.030 - depth)};
        const Vector3d u = to_vector(finger) - to_vector(out.god_object_m);
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
            EXPECT_WITHIN((force - to_vector(out.force_n)).norm(), .count = 16, .epsilon = kFloat, .size = size);
        }
    }
}

/// Force of every tick with the finger at x, until there has been none for a while; its contacts that were given up.
std::vector<double> force_at(const haptable_model& model, haptable_servo& servo, const Vector3d& x,
                             std::uint32_t now_us) {
    const float finger[3] = {float(x.x()), float(x.y()), float(x.z())};
    std::vector<double> force_n;
    haptable_output out;
    for (int tick = 0; tick < 60; ++tick) {
        haptable_servo_step(&model, &servo, finger, now_us += 1000, &out);
        force_n.push_back(to_vector(out.force_n).norm());
    }
    return force_n;
}

// Pushed through the body and out of its other side, which nothing may touch: the god-object is left behind on the top.
// Where the finger is farther from it than the body's diagonal, its force falls to zero over HAPTABLE_FADE_TICKS.
TEST_F(ServoTest, AGodObjectThatIsLeftFarBehindLetsGo) {
    press(0.001);
    for (int mm = 2; mm < 330; ++mm) step({0.0131, 0.0172, 0.030 - 0.001 * mm});
    EXPECT_EQ(servo.contact.patch, HAPTABLE_NONE);
    EXPECT_EQ(servo.counters.given_up, 1U);
    expect_silent_output();
    step({0.0131, 0.0172, 0.031});
    step({0.0131, 0.0172, 0.029});
    EXPECT_EQ(out.state, HAPTABLE_CONTACT) << "it may touch again";
}

TEST_F(ServoTest, AGodObjectThatALeapLeavesFarBehindLetsGoByARelease) {
    press(0.002);
    const std::vector<double> force_n = force_at(*model.get(), servo, {0.0131, 0.0172, 0.030 - 0.3}, now_us);
    const double most_n = double(model.get()->max_force_n);
    EXPECT_WITHIN(std::abs(force_n.front() - most_n), .count = 8, .epsilon = kFloat, .size = most_n);
    EXPECT_EQ(force_n.back(), 0.0);
    for (std::size_t i = 1; i < force_n.size(); ++i) {
        EXPECT_LE(force_n[i], force_n[i - 1]);
        EXPECT_GE(force_n[i], force_n[i - 1] - 1.01 * most_n / HAPTABLE_FADE_TICKS) << "a jump";
    }
    EXPECT_EQ(servo.counters.given_up, 1U);
}

// Less far than the body is large it stays, and its force with it.
TEST_F(ServoTest, AGodObjectThatIsNearKeepsItsForce) {
    press(0.002);
    const double diagonal_m = std::sqrt(3.0) * 0.03;
    const std::vector<double> force_n =
        force_at(*model.get(), servo, {0.0131, 0.0172, 0.030 - 0.99 * diagonal_m}, now_us);
    EXPECT_EQ(force_n.front(), force_n.back());
    EXPECT_EQ(servo.counters.given_up, 0U);
}

TEST_F(ServoTest, AFixedNodeIsRigid) {
    const TestModel half_fixed(box_shape(4, Vector3d(0.03, 0.03, 0.03)), 0.02);
    const float before[3] = {-0.001F, 0.015F, 0.01F}, in[3] = {0.001F, 0.015F, 0.01F};
    haptable_servo_step(half_fixed.get(), &servo, before, 0, &out);
    haptable_servo_step(half_fixed.get(), &servo, in, 1000, &out);
    ASSERT_EQ(out.state, HAPTABLE_CONTACT);
    // 1 mm is told from positions of up to 30 mm.
    const Bound bound{.count = 8, .epsilon = kFloat, .condition = 30.0, .size = 1000.0 * 0.001};
    EXPECT_WITHIN(std::abs(double(out.force_n[0]) + 1000.0 * 0.001), bound);
    EXPECT_WITHIN(std::abs(double(out.force_n[1])), bound);
}

// Sliding over faces, edges and vertices of the top: the force changes by no more than stiffness times the way.
TEST_F(ServoTest, ForceIsContinuousOverEdgesAndVertices) {
    double most = 0.0;
    for (int v = 0; v < int(model.servo().vertex_m.size()); ++v)
        most = std::max(most, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(model.stiffness(v)).eigenvalues()[2]);
    const double step_m = 1e-5, depth = 0.002, edge = 0.0075;
    // S changes by at most 2 max|S| over a patch at least edge/sqrt(2) high.
    const double bound = step_m * (most + 2 * most * depth / (edge / std::sqrt(2.0)));
    for (const Vector3d& way : {Vector3d(1, 1, 0), Vector3d(1, 0, 0), Vector3d(0.31, 0.95, 0)}) {
        haptable_servo_init(&servo);
        const Vector3d begin(0.0075, 0.0075, 0.030 - depth);  // over a vertex
        step(begin + Vector3d(0, 0, 0.003));
        step(begin);
        Vector3d before = to_vector(out.force_n);
        std::uint16_t patch = out.patch;
        int crossings = 0;
        for (int i = 1; i * step_m < 0.015; ++i) {
            step(begin + i * step_m * way.normalized());
            ASSERT_EQ(out.state, HAPTABLE_CONTACT);
            ASSERT_WITHIN((to_vector(out.force_n) - before).norm(), .epsilon = bound) << "after " << i << " steps";
            before = to_vector(out.force_n);
            crossings += out.patch != patch;
            patch = out.patch;
        }
        EXPECT_GE(crossings, 2);
    }
}

TEST_F(ServoTest, TheForceIsCutToTheDevicesLimitAndKeepsItsDirection) {
    press(0.08);  // out through the bottom: held all the same
    const Vector3d force = to_vector(out.force_n);
    Vector3d wanted = Vector3d::Zero();
    for (const auto& nodal : out.nodal_force_n) wanted -= to_vector(nodal);
    ASSERT_GT(wanted.norm(), 8.5 * 1.01) << "press harder: the test must clamp";
    EXPECT_WITHIN(std::abs(force.norm() - 8.5), .count = 16, .epsilon = kFloat, .size = 8.5);
    EXPECT_WITHIN(force.normalized().cross(wanted.normalized()).norm(), .count = 16, .epsilon = kFloat);
    EXPECT_EQ(servo.counters.clamped_forces, 1U);
}

TEST_F(ServoTest, SilenceBringsTheForceToZero) {
    EXPECT_EQ(haptable_servo_watch(&servo, 0, &out), 1) << "no position yet";
    now_us = 0xFFFFFFFFU - 1500;  // the clock wraps within the test
    press(0.001);
    EXPECT_EQ(haptable_servo_watch(&servo, now_us + HAPTABLE_SILENCE_US - 1, &out), 0);
    EXPECT_EQ(out.state, HAPTABLE_CONTACT);
    EXPECT_EQ(haptable_servo_watch(&servo, now_us + HAPTABLE_SILENCE_US, &out), 1);
    EXPECT_EQ(out.state, HAPTABLE_SILENT);
    expect_silent_output();
    EXPECT_EQ(servo.counters.silences, 1U);
    EXPECT_EQ(haptable_servo_watch(&servo, now_us + 10 * HAPTABLE_SILENCE_US, &out), 1);
    EXPECT_EQ(servo.counters.silences, 1U) << "one silence is counted once";
    press(0.001);
    EXPECT_EQ(out.state, HAPTABLE_CONTACT);
}

// All of it is a plain scene's too: what a mode remembers for itself stands beside its model.
TEST_F(ServoTest, StateIsSmall) {
    EXPECT_LE(sizeof(haptable_servo), 304U);
    EXPECT_LE(offsetof(haptable_servo, nearest_m2), 240U) << "in the paper's mode";
}

}  // namespace
}  // namespace haptable::test
