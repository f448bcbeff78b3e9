// SPDX-License-Identifier: GPL-2.0-or-later
// The simulated device against closed forms of its equation of motion.
#include "host/device/point_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/base/error.hpp"
#include "host/scene/device_models.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 5e-5;

Device device_with(double friction_n, double damping_n_s_per_m) {
    Device device;
    device.friction_n = friction_n;
    device.damping_n_s_per_m = damping_n_s_per_m;
    return device;
}

HandGoal at_rest(const Vector3d& position_m) { return {position_m, Vector3d::Zero()}; }

/// So many steps while the hand's goal rests.
void advance(PointDevice& point, int steps, const Vector3d& goal_m = Vector3d::Zero()) {
    for (int i = 0; i < steps; ++i) point.advance(at_rest(goal_m), kStep_s);
}

void expect_energy_never_grows(PointDevice point, const Vector3d& goal_m, double step_s, int steps) {
    double energy = point.energy_j(goal_m);
    for (int i = 0; i < steps; ++i) {
        point.advance(at_rest(goal_m), step_s);
        const double now = point.energy_j(goal_m);
        ASSERT_WITHIN(now - energy, .count = 64, .size = energy) << "step " << i;
        energy = now;
    }
}

// With friction it stops within f/k of the goal.
TEST(PointDevice, StopsWithinItsFriction) {
    const Device device = device_with(0.04, 0.005);
    PointDevice point(device, Hand{200.0, 5.0}, Vector3d(0.02, 0.01, 0.0));
    advance(point, 40000);
    const Vector3d stopped = point.position_m();
    EXPECT_EQ(point.velocity_m_s().norm(), 0.0);
    EXPECT_LE(stopped.norm(), device.friction_n / 200.0);
    EXPECT_GT(stopped.norm(), 0.0);
    advance(point, 1);
    EXPECT_EQ(point.position_m(), stopped);
}

// Without motors and with a goal at rest nothing adds energy: at any step, stiffness and friction, with any masses.
TEST(PointDevice, EnergyNeverGrowsWithoutForce) {
    const Vector3d start_m(0.02, -0.01, 0.03);
    for (const double step_s : {1e-5, kStep_s, 1e-3, 0.1})
        for (const double stiffness : {0.0, 200.0, 1e5})
            for (const double friction : {0.0, 0.04, 1.0}) {
                SCOPED_TRACE(testing::Message() << step_s << " " << stiffness << " " << friction);
                const PointDevice point(device_with(friction, 0.0), Hand{stiffness, 0.0}, start_m);
                expect_energy_never_grows(point, Vector3d(0.001, 0.0, 0.002), step_s, 3000);
            }
    Device device = device_with(0.04, 0.0);
    device.mass_kg = {0.02, 0.3, 5.0};
    expect_energy_never_grows(PointDevice(device, Hand{200.0, 0.0}, start_m), Vector3d::Zero(), kStep_s, 20000);
}

TEST(PointDevice, MotorsHaveALimit) {
    Device device;
    device.max_force_n = 2.0;
    PointDevice point(device, Hand{}, Vector3d::Zero());
    const auto given = [&](double x, double y, double z) {
        point.set_force(Vector3d(x, y, z));
        return point.force_n();
    };
    EXPECT_EQ(given(1.0, 0.0, -1.0), Vector3d(1.0, 0.0, -1.0));
    EXPECT_WITHIN((given(1.5, 0.0, -2.0) - Vector3d(1.2, 0.0, -1.6)).norm(), .count = 16, .size = 2.0);
    EXPECT_WITHIN((given(3e200, 0.0, -4e200) - Vector3d(1.2, 0.0, -1.6)).norm(), .count = 16, .size = 2.0);
    EXPECT_EQ(given(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0), Vector3d::Zero());
    EXPECT_EQ(given(0.0, std::numeric_limits<double>::infinity(), 0.0), Vector3d::Zero());
}

TEST(PointDevice, EncodersReadTheirGrid) {
    Device device;
    device.encoder_step_m = 3e-5;
    const PointDevice point(device, Hand{}, Vector3d(4.4e-5, 4.6e-5, -4.6e-5));
    EXPECT_WITHIN((point.encoder_m() - Vector3d(3e-5, 6e-5, -6e-5)).norm(), .count = 4, .size = 6e-5);
    device.encoder_step_m = 0.0;
    EXPECT_EQ(PointDevice(device, Hand{}, Vector3d(0.1, 0.2, 0.3)).encoder_m(), Vector3d(0.1, 0.2, 0.3));
}

// The equation of the midpoint rule itself, with another mass along each axis and half of the weight:
// a_i w_i + f w_i/|w| = r_i.
TEST(PointDevice, KeepsTheEquationInEveryStep) {
    Device device = device_with(0.3, 0.01);
    device.mass_kg = {0.05, 0.2, 1.5};
    device.unbalanced = 0.5;
    device.up = {0.0, 1.0, 0.0};
    const Hand hand{300.0, 2.0};
    const Vector3d mass(device.mass_kg.data()), weight(0.0, -0.5 * mass.y() * 9.80665, 0.0);
    for (const double step_s : {1e-5, kStep_s, 1e-3}) {
        PointDevice point(device, hand, Vector3d(0.02, -0.01, 0.005));
        point.set_force(Vector3d(0.4, -1.0, 2.0));
        for (int i = 0; i < 400; ++i) {
            const Vector3d x = point.position_m(), v = point.velocity_m_s();
            point.advance(at_rest(Vector3d::Zero()), step_s);
            const Vector3d w = 0.5 * (v + point.velocity_m_s()), middle = x + 0.5 * step_s * w;
            if (point.velocity_m_s().norm() == 0.0) break;  // friction holds it
            ASSERT_WITHIN((point.position_m() - x - step_s * w).norm(), .count = 16, .size = 0.05) << "step " << i;
            const Vector3d forces = -hand.stiffness_n_per_m * middle - (hand.damping_n_s_per_m + 0.01) * w -
                                    0.3 / w.norm() * w + point.force_n() + weight;
            const Vector3d inertia = mass.cwiseProduct(point.velocity_m_s() - v) / step_s;
            // Terms of up to 6 N and of m v / h; Newton's steps end at 1e-15 of the speed.
            const double size = 12.0 + 4.0 * mass.cwiseProduct(v.cwiseAbs()).maxCoeff() / step_s;
            ASSERT_WITHIN((forces - inertia).norm(), .count = 64, .size = size) << "step " << i;
        }
        EXPECT_GT((point.position_m() - Vector3d(0.02, -0.01, 0.005)).norm(), 1e-5) << "it moved";
    }
}

// a(t) = F (1 - exp(-2 pi f t)): exact at every step.
TEST(PointDevice, MotorsComeUpWithTheirLag) {
    Device device;
    device.bandwidth_hz = 100.0;
    PointDevice point(device, Hand{}, Vector3d::Zero());
    point.set_force(Vector3d(0.0, 0.0, 2.0));
    for (int i = 1; i <= 200; ++i) {
        point.advance(at_rest(Vector3d::Zero()), kStep_s);
        const double exact = 2.0 * (1.0 - std::exp(-2.0 * M_PI * 100.0 * i * kStep_s));
        EXPECT_WITHIN(std::abs(point.acting_n().z() - exact), .count = 8.0 + i, .size = 2.0);
    }
}

TEST(PointDevice, AForceActsAfterItsDelay) {
    Device device;
    device.delay_s = 2e-3;
    PointDevice point(device, Hand{}, Vector3d::Zero());
    for (int i = 0; i < 100; ++i) {
        if (i % 20 == 0) point.set_force(Vector3d(1.0 + i / 20, 0.0, 0.0));
        point.advance(at_rest(Vector3d::Zero()), kStep_s);
        EXPECT_EQ(point.acting_n().x(), i < 40 ? 0.0 : 1.0 + (i - 40) / 20) << i;
    }
}

TEST(PointDevice, StopsAtItsReach) {
    Device device = device_with(0.0, 0.0);
    device.reach_m = {0.1, 0.0, 0.04};
    PointDevice point(device, Hand{0.0, 0.0}, Vector3d::Zero());
    point.set_force(Vector3d(1.0, 1.0, -1.0));
    advance(point, 10000);
    EXPECT_EQ(point.position_m().x(), 0.05);
    EXPECT_EQ(point.position_m().z(), -0.02);
    EXPECT_EQ(point.velocity_m_s().x(), 0.0);
    EXPECT_GT(point.position_m().y(), 1.0) << "that axis is endless";
    point.set_force(Vector3d(-1.0, 0.0, 0.0));
    advance(point, 100);
    EXPECT_LT(point.position_m().x(), 0.05) << "a stop holds in one direction only";
}

TEST(DeviceModels, TheDefaultIsTodaysDevice) { EXPECT_TRUE(device_of(device_models().front()) == Device()); }

TEST(DeviceModels, EveryFigureHasASource) {
    for (const DeviceModel& model : device_models()) {
        EXPECT_EQ(find_device_model(model.name), &model) << "two of one name";
        for (const Figure& figure :
             {model.max_force_n, model.continuous_force_n, model.mass_kg, model.friction_n, model.damping_n_s_per_m,
              model.encoder_step_m, model.bandwidth_hz, model.delay_s, model.unbalanced}) {
            EXPECT_FALSE(std::string(figure.source).empty()) << model.name;
            EXPECT_GE(figure.value, 0.0) << model.name;
        }
        EXPECT_LE(model.continuous_force_n.value, model.max_force_n.value) << model.name;
        EXPECT_GT(model.mass_kg.value, 0.0) << model.name;
        EXPECT_EQ(Vector3d(model.up.data()).norm(), 1.0) << model.name;
    }
    EXPECT_EQ(find_device_model("phantasm"), nullptr);
}

TEST(Hands, HaveNames) {
    EXPECT_EQ(hand_named("default").stiffness_n_per_m, Hand().stiffness_n_per_m);
    EXPECT_LT(hand_named("soft").stiffness_n_per_m, hand_named("default").stiffness_n_per_m);
    EXPECT_GT(hand_named("stiff").stiffness_n_per_m, hand_named("default").stiffness_n_per_m);
    EXPECT_THROW(hand_named("third"), Error);
}

}  // namespace
}  // namespace haptable::test
