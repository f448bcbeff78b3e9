// SPDX-License-Identifier: GPL-2.0-or-later
// A tool's orientation on its way: path, hand, mapping.
#include "host/device/wrist.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/device/mapping.hpp"
#include "host/device/path.hpp"

namespace haptable::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kStep_s = 5e-5;

/// Rotation vector from one to the other.
double angle_between(const Quaterniond& a, const Quaterniond& b) { return rotation_vector(a * b.conjugate()).norm(); }

TEST(Wrist, ComesToItsGoal) {
    const Quaterniond goal = turned_by(Vector3d(0.3, -0.5, 0.2));
    Wrist wrist(Quaterniond::Identity());
    double before = angle_between(wrist.now().turn, goal);
    for (int k = 0; k < 10000; ++k) wrist.advance({goal, Vector3d::Zero()}, kStep_s);
    EXPECT_GT(before, 0.5);
    EXPECT_LT(angle_between(wrist.now().turn, goal), 1e-6);
    EXPECT_LT(wrist.now().spin_rad_s.norm(), 1e-6);
    EXPECT_NEAR(wrist.now().turn.norm(), 1.0, 1e-12);
}

/// A steady torque turns it about its own axis, by the torque over the hand's stiffness, 1 N m/rad.
TEST(Wrist, GivesWayToATorque) {
    const Vector3d torque(0.0, 0.05, 0.0);
    Wrist wrist(Quaterniond::Identity());
    wrist.set_torque(torque);
    for (int k = 0; k < 20000; ++k) wrist.advance({}, kStep_s);
    EXPECT_LT((rotation_vector(wrist.now().turn) - torque).norm(), 1e-6);
    wrist.set_torque(Vector3d(std::nan(""), 0.0, 0.0));
    for (int k = 0; k < 20000; ++k) wrist.advance({}, kStep_s);
    EXPECT_LT(rotation_vector(wrist.now().turn).norm(), 1e-6);
}

class TurningPath : public testing::TestWithParam<const char*> {};

/// The place of the tool that touches stays where it is while the hand turns it; velocities are the positions'.
TEST_P(TurningPath, TurnsAboutWhereItTouches) {
    PathOptions options;
    options.direction = Vector3d(1.0, 2.0, -2.0);
    options.turn_deg = 20.0;
    options.reach_m = 0.04;
    const Vector3d into = options.direction.normalized(), deepest = options.at_m + options.depth_m * into;
    const auto path = scripted_path(GetParam(), options);
    double most = 0.0;
    for (double t = 1e-5; t < path->duration_s() - 1e-5; t += 1.3e-3) {
        const HandGoal goal = path->at(t), before = path->at(t - 1e-5), after = path->at(t + 1e-5);
        const Vector3d touches = goal.position_m + goal.wrist.turn * Vector3d(0.0, 0.0, -options.reach_m);
        EXPECT_LT((touches - options.at_m).cross(into).norm(), 1e-9) << t;
        EXPECT_LT((touches - options.at_m).dot(into), options.depth_m + 1e-9) << t;
        const Vector3d spin = rotation_vector(after.wrist.turn * before.wrist.turn.conjugate()) / 2e-5;
        EXPECT_LT((spin - goal.wrist.spin_rad_s).norm(), 1e-3) << t;
        EXPECT_LT(((after.position_m - before.position_m) / 2e-5 - goal.velocity_m_s).norm(), 1e-4) << t;
        const double turned = std::acos(std::clamp((goal.wrist.turn * -Vector3d::UnitZ()).dot(into), -1.0, 1.0));
        most = std::max(most, turned);
        EXPECT_TRUE(turned < 1e-3 || (touches - deepest).norm() < 1e-9) << t;
    }
    EXPECT_NEAR(most, 20.0 * std::numbers::pi / 180.0, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(All, TurningPath, testing::Values("roll", "tilt", "poke,roll,tilt"));

TEST(RecordedPath, TurnsEvenlyBetweenItsTicks) {
    FingerTick first, second;
    first.turn = {1.0, 0.0, 0.0, 0.0};
    second.turn = {std::cos(0.1), 0.0, std::sin(0.1), 0.0};  // 0.2 rad about y in a millisecond
    const auto path = recorded_path({first, second});
    const HandGoal middle = path->at(0.5e-3);
    EXPECT_LT((rotation_vector(middle.wrist.turn) - Vector3d(0.0, 0.1, 0.0)).norm(), 1e-12);
    EXPECT_LT((middle.wrist.spin_rad_s - Vector3d(0.0, 200.0, 0.0)).norm(), 1e-9);
}

DeviceMap mirrored() {
    DeviceMap map;
    map.rotation_deg = {20.0, -70.0, 130.0};
    map.left_handed = true;
    map.force_scale = 3.0;
    map.motion_scale = 0.25;
    return map;
}

/// Turned back as it was; and the torque gives the hand the power, times the force's scale, that it gives the body.
TEST(TurnMapping, IsInvertedAndKeepsPower) {
    const DeviceMapping mapping(mirrored());
    for (int k = 1; k < 50; ++k) {
        const Vector3d some(std::sin(1.7 * k), std::cos(2.3 * k), std::sin(0.9 * k + 1.0));
        const Turning hand{turned_by(2.0 * some), some};
        const Turning body = mapping.to_body(hand), back = mapping.to_device(body);
        EXPECT_LT(angle_between(back.turn, hand.turn), 1e-12);
        EXPECT_LT((back.spin_rad_s - hand.spin_rad_s).norm(), 1e-12);
        const Vector3d torque(std::cos(k), 0.3, std::sin(3.0 * k));
        EXPECT_NEAR(mapping.torque_to_motors(torque).dot(hand.spin_rad_s), 3.0 * torque.dot(body.spin_rad_s), 1e-12);
        // The body's turning is that of the place that the hand sees turn.
        const double h = 1e-6;
        const Turning later = mapping.to_body(Turning{turned_by(h * hand.spin_rad_s) * hand.turn, some});
        EXPECT_LT((rotation_vector(later.turn * body.turn.conjugate()) / h - body.spin_rad_s).norm(), 1e-5);
    }
}

/// While the clutch is held the tool does not turn; then it goes on from there.
TEST(TurnMapping, TheClutchHoldsTheTool) {
    DeviceMapping mapping(mirrored());
    const auto at = [](int tick) { return Turning{turned_by(Vector3d(0.0, 1e-3 * tick, 0.0)), Vector3d::Zero()}; };
    mapping.follow(Vector3d::Zero(), false, 1e-3, at(0));
    const Quaterniond begun = mapping.tool().turn;
    for (int tick = 1; tick <= 300; ++tick) mapping.follow(Vector3d::Zero(), tick < 200, 1e-3, at(tick));
    EXPECT_NEAR(angle_between(mapping.tool().turn, begun), 1e-3 * (300 - 200), 1e-9);
}

}  // namespace
}  // namespace haptable::test
