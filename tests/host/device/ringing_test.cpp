// SPDX-License-Identifier: GPL-2.0-or-later
// From which stiffness on a loop rings, against closed forms and against what codegen promises.
#include "host/device/ringing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "codegen/model.hpp"
#include "host/device/session.hpp"
#include "host/device/simulated_driver.hpp"
#include "host/scene/device_models.hpp"
#include "host/scene/scene.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kRing_s = 1e-3;
// Of the search, and of a cycle that the sampling deforms: (w T)^2 of w = sqrt(K/m), here below 0.3.
constexpr double kSearched = 0.01, kDeformed = 0.1;

/// In no hand, at 0.5 m/s.
RingingLoop alone(const Device& device) {
    RingingLoop loop;
    loop.device = device;
    return loop;
}

RingingLoop plain(double damping_n_s_per_m, double friction_n, double delay_s) {
    RingingLoop loop;
    loop.device.damping_n_s_per_m = damping_n_s_per_m;
    loop.device.friction_n = friction_n;
    loop.device.encoder_step_m = 0.0;
    loop.device.delay_s = delay_s;
    return loop;
}

// Colgate and Schenkel's bound is where it rings, for a device with damping alone: K = 2 b / T; with a delay
// K = b / (T/2 + d) (Gil et al. 2009).
TEST(Ringing, OfDampingAloneBeginsAtColgateAndSchenkelsBound) {
    for (const double delay_s : {0.0, 1e-3, 2e-3}) {
        const double bound = 0.05 / (kRing_s / 2.0 + delay_s);
        const double measured = ringing_stiffness(plain(0.05, 0.0, delay_s));
        EXPECT_WITHIN(std::abs(measured / bound - 1.0), .epsilon = kSearched + kDeformed) << delay_s;
    }
}

// The describing function of Coulomb friction: it takes 4 f A a cycle, the late spring gives pi K (T/2 + d) v A.
TEST(Ringing, WithCoulombFrictionBeginsWhereACycleGivesMoreThanItTakes) {
    for (const double speed_m_s : {0.1, 0.5}) {
        RingingLoop loop = plain(0.005, 0.04, 1e-3);
        loop.speed_m_s = speed_m_s;
        const double exact = (0.005 + 4.0 * 0.04 / (std::numbers::pi * speed_m_s)) / (1.5 * kRing_s);
        EXPECT_WITHIN(std::abs(ringing_stiffness(loop) / exact - 1.0), .epsilon = kSearched + kDeformed) << speed_m_s;
    }
}

TEST(Ringing, WithoutAnythingThatTakesEnergyItAlwaysRings) {
    EXPECT_EQ(ringing_stiffness(alone(device_of(*find_device_model("ideal")))), 0.0);
}

// The hand takes what the device does not.
TEST(Ringing, AHandHoldsIt) {
    RingingLoop loop = alone(Device());
    const double in_none = ringing_stiffness(loop);
    loop.hand = hand_named("soft");
    EXPECT_GT(ringing_stiffness(loop), 5.0 * in_none);
}

// What codegen promises, to a hand that moves at up to 0.5 m/s, holds, and is not half of what it could promise.
TEST(Ringing, BeginsWithinAFactorOfTwoOfCodegensLimit) {
    for (const char* model : {"phantom", "premium-1.0", "touch", "omega.3", "inverse3"})
        for (const double later_s : {0.0, 1e-3}) {
            RingingLoop loop = alone(device_of(*find_device_model(model)));
            loop.device.delay_s += later_s;
            Tables tables;
            tables.damping_n_s_per_m = loop.device.damping_n_s_per_m;
            tables.device_friction_n = loop.device.friction_n;
            tables.encoder_step_m = loop.device.encoder_step_m;
            tables.device_delay_s = whole_delay_s(loop.device);
            const double promised = stable_stiffness(tables), measured = ringing_stiffness(loop);
            EXPECT_GE(measured, promised) << model << " " << later_s;
            EXPECT_LE(measured, 2.0 * promised) << model << " " << later_s;
        }
}

/// The largest speed in the last half second of two, of a device that turns at x = 0 of a spring in the real session.
double speed_after_two_seconds(double stiffness_n_per_m) {
    Connection connection("memq://");
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state& state, std::int64_t) {
        servo_force force{};
        force.seq = state.seq;
        force.session = force.owner = state.session;
        force.servo = 1;
        force.model_hash = 1;
        force.servo_state = servo_force::CONTACT;
        force.force_n[0] = -stiffness_n_per_m * state.position_m[0];
        connection.publish(channel_of<servo_force>(), force);
    });
    const double begin_m = 0.5 * std::sqrt(Device().mass_kg[0] / stiffness_n_per_m);
    const auto path = recorded_path({FingerTick{}});
    double most = 0.0;
    SessionOptions options;
    options.lockstep = true;
    options.seconds = 2.0;
    options.watch = [&most](const DeviceRow& row) {
        if (row.tick >= 1500) most = std::max(most, std::abs(row.velocity_m_s.x()));
    };
    SimulatedDriver driver(PointDevice(Device(), Hand{0.0, 0.0}, Vector3d(begin_m, 0.0, 0.0)), *path);
    DeviceSession(driver, connection, options, nullptr).run();
    return most;
}

// The session in lockstep, over messages, rings where the bare loop says so.
TEST(Ringing, OfTheSessionIsThatOfTheLoop) {
    const double begins = ringing_stiffness(alone(Device()));
    EXPECT_LT(speed_after_two_seconds(0.8 * begins), 0.45);
    EXPECT_GT(speed_after_two_seconds(1.25 * begins), 0.55);
}

}  // namespace
}  // namespace haptable::test
