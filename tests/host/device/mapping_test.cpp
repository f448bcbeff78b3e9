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

/// The finger's and the share's largest steps while the device moves along x at 0.1 m/s, the clutch held from tick 100
/// to 400.
struct Steps {
    double finger_m = 0.0, share = 0.0, least_share = 1.0;
};

Steps clutch_in_the_middle(DeviceMapping& mapping) {
    Steps steps;
    Vector3d last_m = Vector3d::Zero();
    double last_share = 1.0;
    for (int tick = 0; tick < 700; ++tick) {
        mapping.follow(Vector3d(1e-4 * tick, 0.0, 0.0), tick >= 100 && tick < 400, kTick_s);
        if (tick > 0) steps.finger_m = std::max(steps.finger_m, (mapping.finger_m() - last_m).norm());
        steps.share = std::max(steps.share, std::abs(mapping.share() - last_share));
        steps.least_share = std::min(steps.least_share, mapping.share());
        last_m = mapping.finger_m();
        last_share = mapping.share();
    }
    return steps;
}

TEST(DeviceMapping, TheClutchMakesNoStep) {
    DeviceMap map = odd_map();
    map.ramp_s = 0.05;
    DeviceMapping mapping(map);
    const Vector3d begun_m = mapping.to_body(Vector3d::Zero());
    const Steps steps = clutch_in_the_middle(mapping);
    // A tick's own motion, scaled, and 1/50 of the force.
    EXPECT_WITHIN(steps.finger_m - 0.25 * 1e-4, .count = 64, .size = 0.5);
    EXPECT_WITHIN(steps.share - 1.0 / 50.0, .count = 64);
    EXPECT_EQ(steps.least_share, 0.0);
    EXPECT_EQ(mapping.share(), 1.0);
    // 300 ticks of the way did not count.
    const Vector3d went_m = mapping.finger_m() - begun_m;
    EXPECT_WITHIN(std::abs(went_m.norm() - 0.25 * 1e-4 * (699 - 300 - 1)), .count = 2000, .size = 0.5);
    EXPECT_WITHIN((mapping.to_body(Vector3d(1e-4 * 699, 0.0, 0.0)) - mapping.finger_m()).norm(), .count = 64);
}

TEST(DeviceMapping, TheFingerStaysWhileTheClutchIsHeld) {
    DeviceMapping mapping(odd_map());
    mapping.follow(Vector3d(0.01, 0.02, 0.03), false, kTick_s);
    const Vector3d held_m = mapping.finger_m();
    for (int tick = 1; tick < 50; ++tick) {
        mapping.follow(Vector3d(0.01 + 1e-3 * tick, 0.02, 0.03), true, kTick_s);
        EXPECT_WITHIN((mapping.finger_m() - held_m).norm(), .count = 8.0 * tick, .size = 1.0);
    }
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
