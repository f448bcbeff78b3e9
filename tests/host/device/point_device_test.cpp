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

// m x'' + d x' + k x = 0, x(0) = x0, x'(0) = 0, under-damped:
// x = x0 exp(-z w t) (cos(wd t) + z w / wd sin(wd t)), w = sqrt(k/m), z = d / (2 sqrt(k m)), wd = w sqrt(1 - z^2)
double free_oscillation(double x0, double m, double k, double d, double t) {
    const double w = std::sqrt(k / m), z = d / (2.0 * std::sqrt(k * m)), wd = w * std::sqrt(1.0 - z * z);
    return x0 * std::exp(-z * w * t) * (std::cos(wd * t) + z * w / wd * std::sin(wd * t));
}

/// The largest distance from the closed form over 0.4 s, relative to the first displacement.
double oscillation_error(double step_s) {
    const Device device = device_with(0.0, 0.5);
    const Hand hand{200.0, 1.0};
    PointDevice point(device, hand, Vector3d(0.01, 0.0, 0.0));
    double worst = 0.0;
    const int steps = static_cast<int>(std::lround(0.4 / step_s));
    for (int i = 1; i <= steps; ++i) {
        point.advance(at_rest(Vector3d::Zero()), step_s);
        const double exact = free_oscillation(0.01, device.mass_kg[0], 200.0, 1.5, i * step_s);
        worst = std::max(worst, std::abs(point.position_m().x() - exact) / 0.01);
    }
    return worst;
}

TEST(PointDevice, OscillatesAndDecaysAsTheClosedFormSays) {
    // The trapezoid rule's phase falls behind by (w h)^2 / 12 of the way w t that it went.
    const double w = std::sqrt(200.0 / Device().mass_kg[0]), phase = std::pow(w * kStep_s, 2) / 12.0 * w * 0.4;
    EXPECT_WITHIN(oscillation_error(kStep_s), .count = 3, .epsilon = phase);
}

TEST(PointDevice, IsOfSecondOrder) {
    const double coarse = oscillation_error(1e-3), fine = oscillation_error(5e-4);
    EXPECT_WITHIN(std::abs(std::log2(coarse / fine) - 2.0), .epsilon = 0.05);
}

// F = k (x - x_t): where the motors and the hand balance.
TEST(PointDevice, SettlesWhereForcesBalance) {
    PointDevice point(device_with(0.0, 0.005), Hand{200.0, 5.0}, Vector3d(0.02, 0.0, -0.01));
    const Vector3d goal(0.001, 0.002, 0.003), force(0.5, -1.0, 2.0);
    point.set_force(force);
    for (int i = 0; i < 40000; ++i) point.advance(at_rest(goal), kStep_s);
    EXPECT_WITHIN((point.position_m() - (goal + force / 200.0)).norm(), .epsilon = 1e-12);
    EXPECT_WITHIN(point.velocity_m_s().norm(), .epsilon = 1e-12);
}

// With friction it stops within f/k of the goal.
TEST(PointDevice, StopsWithinItsFriction) {
    const Device device = device_with(0.04, 0.005);
    PointDevice point(device, Hand{200.0, 5.0}, Vector3d(0.02, 0.01, 0.0));
    for (int i = 0; i < 40000; ++i) point.advance(at_rest(Vector3d::Zero()), kStep_s);
    const Vector3d stopped = point.position_m();
    EXPECT_EQ(point.velocity_m_s().norm(), 0.0);
    EXPECT_LE(stopped.norm(), device.friction_n / 200.0);
    EXPECT_GT(stopped.norm(), 0.0);
    point.advance(at_rest(Vector3d::Zero()), kStep_s);
    EXPECT_EQ(point.position_m(), stopped);
}

// A free mass under Coulomb friction alone: v = v0 - f t / m, straight, and it stays where it stops.
TEST(PointDevice, FrictionBrakesEvenlyAndAgainstTheMotion) {
    const Device device = device_with(0.04, 0.0);
    PointDevice point(device, Hand{0.0, 0.0}, Vector3d::Zero());
    point.set_force(Vector3d(3.0, 4.0, 0.0));
    for (int i = 0; i < 2000; ++i) point.advance(at_rest(Vector3d::Zero()), kStep_s);
    const double v0 = point.velocity_m_s().norm();
    // 2,000 steps of one rounded size are added up.
    const Bound added{.count = 4.0 * 2000.0, .size = v0};
    EXPECT_WITHIN(std::abs(v0 - (5.0 - 0.04) / device.mass_kg[0] * 0.1), added);
    point.set_force(Vector3d::Zero());
    for (int i = 0; i < 2000; ++i) point.advance(at_rest(Vector3d::Zero()), kStep_s);
    EXPECT_WITHIN(std::abs(point.velocity_m_s().norm() - v0 + 0.04 / device.mass_kg[0] * 0.1), added);
    EXPECT_WITHIN(std::abs(point.velocity_m_s().x() / point.velocity_m_s().y() - 0.75), added.times(1.0 / v0));
}

// Without motors and with a goal at rest nothing adds energy: at any step, stiffness and friction.
TEST(PointDevice, EnergyNeverGrowsWithoutForce) {
    for (const double step_s : {1e-5, kStep_s, 1e-3, 0.1}) {
        for (const double stiffness : {0.0, 200.0, 1e5}) {
            for (const double friction : {0.0, 0.04, 1.0}) {
                PointDevice point(device_with(friction, 0.0), Hand{stiffness, 0.0}, Vector3d(0.02, -0.01, 0.03));
                const Vector3d goal(0.001, 0.0, 0.002);
                double energy = point.energy_j(goal);
                for (int i = 0; i < 3000; ++i) {
                    point.advance(at_rest(goal), step_s);
                    const double now = point.energy_j(goal);
                    ASSERT_WITHIN(now - energy, .count = 64, .size = energy)
                        << step_s << " " << stiffness << " " << friction;
                    energy = now;
                }
            }
        }
    }
}

// Without any friction it keeps its energy: the scheme itself takes none.
TEST(PointDevice, KeepsItsEnergyWithoutFriction) {
    PointDevice point(device_with(0.0, 0.0), Hand{200.0, 0.0}, Vector3d(0.02, 0.0, 0.0));
    const double energy = point.energy_j(Vector3d::Zero());
    for (int i = 0; i < 20000; ++i) point.advance(at_rest(Vector3d::Zero()), kStep_s);
    // The scheme's coefficients are rounded, which errs the same way in every step.
    EXPECT_WITHIN(std::abs(point.energy_j(Vector3d::Zero()) / energy - 1.0), .count = 16.0 * 20000.0);
}

TEST(PointDevice, MotorsHaveALimit) {
    Device device;
    device.max_force_n = 2.0;
    PointDevice point(device, Hand{}, Vector3d::Zero());
    point.set_force(Vector3d(1.0, 0.0, -1.0));
    EXPECT_EQ(point.force_n(), Vector3d(1.0, 0.0, -1.0));
    point.set_force(Vector3d(1.5, 0.0, -2.0));
    EXPECT_WITHIN((point.force_n() - Vector3d(1.2, 0.0, -1.6)).norm(), .count = 16, .size = 2.0);
    point.set_force(Vector3d(3e200, 0.0, -4e200));
    EXPECT_WITHIN((point.force_n() - Vector3d(1.2, 0.0, -1.6)).norm(), .count = 16, .size = 2.0);
    point.set_force(Vector3d(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0));
    EXPECT_EQ(point.force_n(), Vector3d::Zero());
    point.set_force(Vector3d(0.0, std::numeric_limits<double>::infinity(), 0.0));
    EXPECT_EQ(point.force_n(), Vector3d::Zero());
}

TEST(PointDevice, EncodersReadTheirGrid) {
    Device device;
    device.encoder_step_m = 3e-5;
    const PointDevice point(device, Hand{}, Vector3d(4.4e-5, 4.6e-5, -4.6e-5));
    EXPECT_WITHIN((point.encoder_m() - Vector3d(3e-5, 6e-5, -6e-5)).norm(), .count = 4, .size = 6e-5);
    device.encoder_step_m = 0.0;
    EXPECT_EQ(PointDevice(device, Hand{}, Vector3d(0.1, 0.2, 0.3)).encoder_m(), Vector3d(0.1, 0.2, 0.3));
}

// The equation of the midpoint rule itself, with another mass along each axis: a_i w_i + f w_i/|w| = r_i.
TEST(PointDevice, MassesOfItsOwnAlongEachAxisKeepTheEquation) {
    Device device = device_with(0.3, 0.01);
    device.mass_kg = {0.05, 0.2, 1.5};
    const Hand hand{300.0, 2.0};
    PointDevice point(device, hand, Vector3d(0.02, -0.01, 0.005));
    point.set_force(Vector3d(0.4, -1.0, 2.0));
    const Vector3d mass(device.mass_kg.data());
    for (int i = 0; i < 400; ++i) {
        const Vector3d x = point.position_m(), v = point.velocity_m_s();
        point.advance(at_rest(Vector3d::Zero()), kStep_s);
        const Vector3d w = 0.5 * (v + point.velocity_m_s()), middle = x + 0.5 * kStep_s * w;
        ASSERT_GT(w.norm(), 0.0);
        const Vector3d forces = -hand.stiffness_n_per_m * middle - (hand.damping_n_s_per_m + 0.01) * w -
                                0.3 / w.norm() * w + point.force_n();
        const Vector3d inertia = mass.cwiseProduct(point.velocity_m_s() - v) / kStep_s;
        // Terms of up to 6 N and of m v / h; Newton's steps end at 1e-15 of the speed.
        const double size = 12.0 + 4.0 * mass.cwiseProduct(v.cwiseAbs()).maxCoeff() / kStep_s;
        ASSERT_WITHIN((forces - inertia).norm(), .count = 64, .size = size) << "step " << i;
    }
}

TEST(PointDevice, EnergyNeverGrowsWithMassesOfItsOwn) {
    Device device = device_with(0.04, 0.0);
    device.mass_kg = {0.02, 0.3, 5.0};
    PointDevice point(device, Hand{200.0, 0.0}, Vector3d(0.02, -0.01, 0.03));
    double energy = point.energy_j(Vector3d::Zero());
    for (int i = 0; i < 20000; ++i) {
        point.advance(at_rest(Vector3d::Zero()), kStep_s);
        const double now = point.energy_j(Vector3d::Zero());
        ASSERT_WITHIN(now - energy, .count = 64, .size = energy);
        energy = now;
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

// What nothing balances hangs on the hand: m g / k below where it is held.
TEST(PointDevice, ItsWeightHangsOnTheHand) {
    for (const double share : {0.0, 0.5, 1.0}) {
        Device device = device_with(0.0, 0.005);
        device.unbalanced = share;
        device.up = {0.0, 1.0, 0.0};
        PointDevice point(device, Hand{200.0, 5.0}, Vector3d::Zero());
        for (int i = 0; i < 40000; ++i) point.advance(at_rest(Vector3d::Zero()), kStep_s);
        const Vector3d sagged(0.0, -share * 0.075 * 9.80665 / 200.0, 0.0);
        EXPECT_WITHIN((point.position_m() - sagged).norm(), .epsilon = 1e-12) << share;
    }
}

TEST(PointDevice, StopsAtItsReach) {
    Device device = device_with(0.0, 0.0);
    device.reach_m = {0.1, 0.0, 0.04};
    PointDevice point(device, Hand{0.0, 0.0}, Vector3d::Zero());
    point.set_force(Vector3d(1.0, 1.0, -1.0));
    for (int i = 0; i < 10000; ++i) point.advance(at_rest(Vector3d::Zero()), kStep_s);
    EXPECT_EQ(point.position_m().x(), 0.05);
    EXPECT_EQ(point.position_m().z(), -0.02);
    EXPECT_EQ(point.velocity_m_s().x(), 0.0);
    EXPECT_GT(point.position_m().y(), 1.0) << "that axis is endless";
    point.set_force(Vector3d(-1.0, 0.0, 0.0));
    for (int i = 0; i < 100; ++i) point.advance(at_rest(Vector3d::Zero()), kStep_s);
    EXPECT_LT(point.position_m().x(), 0.05) << "a stop holds in one direction only";
}

TEST(DeviceModels, TheDefaultIsTodaysDevice) {
    const Device named = device_of(device_models().front()), today;
    EXPECT_EQ(named.model, today.model);
    EXPECT_EQ(named.max_force_n, today.max_force_n);
    EXPECT_EQ(named.mass_kg, today.mass_kg);
    EXPECT_EQ(named.damping_n_s_per_m, today.damping_n_s_per_m);
    EXPECT_EQ(named.friction_n, today.friction_n);
    EXPECT_EQ(named.encoder_step_m, today.encoder_step_m);
    EXPECT_EQ(named.bandwidth_hz, 0.0);
    EXPECT_EQ(named.delay_s, 0.0);
    EXPECT_EQ(named.unbalanced, 0.0);
    EXPECT_EQ(named.reach_m, today.reach_m);
}

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
