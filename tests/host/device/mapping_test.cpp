// SPDX-License-Identifier: GPL-2.0-or-later
// The device's coordinates and the body's: frames by hand, power, and that a clutch makes no step.
#include "host/device/mapping.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kTick_s = 1e-3;

DeviceMap odd_map() {
    DeviceMap map;
    map.position_m = {0.1, -0.2, 0.3};
    map.rotation_deg = {30.0, -45.0, 110.0};
    map.motion_scale = 0.25;
    map.force_scale = 3.0;
    return map;
}

// A Touch (x right, y up, z to the user) over a body whose z is up: a quarter turn about x.
TEST(DeviceMapping, TurnsAboutTheBodysAxesOneAfterTheOther) {
    DeviceMap map;
    map.rotation_deg = {90.0, 0.0, 0.0};
    const DeviceMapping quarter(map);
    EXPECT_WITHIN((quarter.to_body(Vector3d(1.0, 2.0, 3.0)) - Vector3d(1.0, -3.0, 2.0)).norm(), .count = 16,
                  .size = 3.0);
    map.rotation_deg = {90.0, 0.0, 90.0};  // the device's y: to z by the first turn, where the second leaves it
    const DeviceMapping two(map);
    EXPECT_WITHIN((two.to_body(Vector3d(0.0, 1.0, 0.0)) - Vector3d(0.0, 0.0, 1.0)).norm(), .count = 16);
    EXPECT_WITHIN((two.to_body(Vector3d(1.0, 0.0, 0.0)) - Vector3d(0.0, 1.0, 0.0)).norm(), .count = 16);
}

TEST(DeviceMapping, ALeftHandedDeviceIsMirroredFirst) {
    DeviceMap map;
    map.left_handed = true;
    map.rotation_deg = {0.0, 0.0, 90.0};
    const DeviceMapping mapping(map);
    EXPECT_WITHIN((mapping.to_body(Vector3d(1.0, 0.0, 0.0)) - Vector3d(0.0, -1.0, 0.0)).norm(), .count = 16);
    EXPECT_WITHIN((mapping.to_motors(Vector3d(0.0, -1.0, 0.0)) - Vector3d(1.0, 0.0, 0.0)).norm(), .count = 16);
}

// There and back, and what the motors give times the hand's way is s_f / s_x of what the body gives times the finger's.
TEST(DeviceMapping, KeepsPlacesAndPower) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const auto draw = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
    for (const bool left : {false, true}) {
        DeviceMap map = odd_map();
        map.left_handed = left;
        const DeviceMapping mapping(map);
        for (int i = 0; i < 100; ++i) {
            const Vector3d x = draw(), v = draw(), f = draw();
            EXPECT_WITHIN((mapping.to_device(mapping.to_body(x)) - x).norm(), .count = 64, .size = x.norm() + 1.0);
            EXPECT_WITHIN((mapping.velocity_to_device(mapping.velocity_to_body(v)) - v).norm(), .count = 64,
                          .size = v.norm());
            const double at_hand = mapping.to_motors(f).dot(v), at_body = f.dot(mapping.velocity_to_body(v));
            EXPECT_WITHIN(std::abs(at_hand - 3.0 / 0.25 * at_body), .count = 64, .size = 3.0 * f.norm() * v.norm());
        }
    }
}

// While the device moves along x at 0.1 m/s, the clutch is held from tick 100 to 400.
TEST(DeviceMapping, TheClutchMakesNoStep) {
    DeviceMap map = odd_map();
    map.ramp_s = 0.05;
    DeviceMapping mapping(map);
    mapping.follow(Vector3d::Zero(), false, kTick_s);
    const Vector3d begun_m = mapping.finger_m();
    double least_share = 1.0;
    for (int tick = 1; tick < 700; ++tick) {
        const Vector3d last_m = mapping.finger_m();
        const double last_share = mapping.share();
        const bool is_held = tick >= 100 && tick < 400;
        mapping.follow(Vector3d(1e-4 * tick, 0.0, 0.0), is_held, kTick_s);
        // A tick's own motion, scaled, and 1/50 of the force.
        const double step_m = (mapping.finger_m() - last_m).norm();
        EXPECT_WITHIN(std::abs(step_m - (is_held || tick == 400 ? 0.0 : 0.25 * 1e-4)), .count = 64, .size = 0.5)
            << tick;
        EXPECT_WITHIN(std::abs(mapping.share() - last_share) - 1.0 / 50.0, .count = 64) << tick;
        least_share = std::min(least_share, mapping.share());
    }
    EXPECT_EQ(least_share, 0.0);
    EXPECT_EQ(mapping.share(), 1.0);
    EXPECT_WITHIN(std::abs((mapping.finger_m() - begun_m).norm() - 0.25 * 1e-4 * (699 - 300 - 1)), .count = 2000,
                  .size = 0.5);
    EXPECT_WITHIN((mapping.to_body(Vector3d(1e-4 * 699, 0.0, 0.0)) - mapping.finger_m()).norm(), .count = 64);
}

TEST(DeviceMapping, OutsideOfTheWorkspaceTheForceFalls) {
    DeviceMap map = odd_map();
    map.workspace_m = {-0.1, -0.1, -0.1, 0.1, 0.1, 0.1};
    map.ramp_s = 0.02;
    DeviceMapping mapping(map);
    const Vector3d inside(0.05, 0.0, 0.0), outside(0.05, 0.0, 0.11);
    mapping.follow(inside, false, kTick_s);
    EXPECT_EQ(mapping.share(), 1.0);
    for (int tick = 1; tick <= 20; ++tick) {
        mapping.follow(outside, false, kTick_s);
        EXPECT_WITHIN(std::abs(mapping.share() - (1.0 - tick / 20.0)), .count = 64);
    }
    EXPECT_EQ(mapping.to_motors(Vector3d(1.0, 2.0, 3.0)).norm(), 0.0);
    EXPECT_WITHIN((mapping.finger_m() - mapping.to_body(outside)).norm(), .count = 4) << "it follows the device";
    for (int tick = 1; tick <= 20; ++tick) mapping.follow(inside, false, kTick_s);
    EXPECT_EQ(mapping.share(), 1.0);
    DeviceMapping begun_outside(map);
    begun_outside.follow(Vector3d(0.0, 0.0, std::numeric_limits<double>::quiet_NaN()), false, kTick_s);
    EXPECT_EQ(begun_outside.share(), 0.0);
}

}  // namespace
}  // namespace haptable::test
