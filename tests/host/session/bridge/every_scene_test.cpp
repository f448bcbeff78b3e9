// SPDX-License-Identifier: GPL-2.0-or-later
// Every combination of fingers, free body and modes behind a line: pose and modes come with each tick's forces.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "host/link/messages.hpp"
#include "host/session/bridge/line_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/loop/every_scene.hpp"

namespace haptable::test {
namespace {

/// A terminal of the kernel's; fingers that come down on both sides of the middle, and push.
class BridgeOfEveryScene : public testing::TestWithParam<Parts> {
protected:
    BridgeOfEveryScene() {
        for (std::size_t finger = 0; finger < fingers; ++finger)
            connection.subscribe<servo_force>(
                channel_of<servo_force>(finger),
                [this, finger](const servo_force& m, std::int64_t) { answered[finger] = m.seq; });
        connection.subscribe<body_pose>(channel_of<body_pose>(),
                                        [this](const body_pose& m, std::int64_t) { poses.push_back(m); });
        connection.subscribe<body_modes>(channel_of<body_modes>(),
                                         [this](const body_modes& m, std::int64_t) { swung.push_back(m); });
    }
    void publish(std::int64_t seq) {
        for (std::size_t finger = 0; finger < fingers; ++finger) {
            if (answered[finger] == seq) continue;
            device_state state = simulated_state(seq, seq * 1000);
            const double in_m = -0.002 + 3e-5 * static_cast<double>(std::min<std::int64_t>(seq, 150));
            state.session += static_cast<std::int64_t>(finger);
            state.position_m[0] = finger == 0 ? in_m : 0.03 - 0.5 * in_m;
            state.position_m[1] = finger == 0 ? 0.013 : 0.016;
            state.position_m[2] = 0.02;
            connection.publish(channel_of<device_state>(finger), state);
        }
        handle_all(connection);
    }
    bool is_answered(std::int64_t seq) const { return answered[0] == seq && (fingers == 1 || answered[1] == seq); }
    void ask(std::int64_t seq) {
        const Clock::time_point give_up = Clock::now() + std::chrono::seconds(20);
        while (!is_answered(seq) && Clock::now() < give_up) {
            publish(seq);
            target.answer();
            session.take_answers();
            session.watch(Clock::now());
            handle_all(connection);
        }
        ASSERT_TRUE(is_answered(seq)) << seq;
    }

    const ServoScene scene = every_scene().scene(GetParam());
    const std::size_t fingers = static_cast<std::size_t>(GetParam().fingers);
    WorkFolder folder;
    const Pty port;
    Connection connection{"memq://"};
    SerialTarget line{Line::open(port.name(), 3'000'000), scene};
    FakeTarget<Pty> target{scene, port};
    std::optional<ServoRecord> record{std::in_place, scene, folder / "bridge.csv"};
    LineStepper stepper{line, {.retry = std::chrono::milliseconds(2)}};
    Session session{stepper, connection, &*record};
    std::array<std::int64_t, kFingers> answered{-1, -1};
    std::vector<body_pose> poses;
    std::vector<body_modes> swung;
};

INSTANTIATE_TEST_SUITE_P(Scenes, BridgeOfEveryScene, testing::ValuesIn(every_combination()),
                         [](const auto& of) { return of.param.name(); });

// It is where the host's servo has it; an answer that is damaged is none, and is asked for again.
TEST_P(BridgeOfEveryScene, IsWhatTheHostHas) {
    constexpr std::int64_t kStates = 250;
    const std::int64_t ticks = kStates + GetParam().fingers - 1;  // who begins first waits for nobody
    for (std::int64_t seq = 0; seq < kStates; ++seq) {
        if (seq == 50) target.damages = 3;
        ASSERT_NO_FATAL_FAILURE(ask(seq));
    }
    EXPECT_EQ(target.counters().ticks, std::uint32_t(ticks)) << "stepped once";
    EXPECT_GT(stepper.counters().contact_ticks, 20);
    EXPECT_GE(stepper.counters().resent_frames, 2) << "one of the damaged answers was a hello";
    EXPECT_EQ(stepper.counters().rejected_forces, 0);
    ASSERT_EQ(poses.size(), GetParam().is_free ? std::size_t(ticks) : 0U);
    ASSERT_EQ(swung.size(), GetParam().rings ? std::size_t(ticks) : 0U);
    if (GetParam().is_free) {
        EXPECT_EQ(poses.back().seq, kStates - 1);
        EXPECT_EQ(poses.back().session, kSession);
        EXPECT_EQ(poses.back().rest_centre_m[2], double{scene.body->centre_m[2]});
        EXPECT_EQ(poses.back().centre_m[0], double{target.said().pose.position_m[0]});
        EXPECT_NE(poses.back().centre_m[0], poses[0].centre_m[0]) << "it is pushed";
        EXPECT_EQ(poses.back().velocity_m_per_s[0], double{target.said().pose.velocity_m_per_s[0]});
        EXPECT_EQ(poses.back().turn[0], double{target.said().pose.turn[0]});
        EXPECT_EQ(poses.back().utime, 1000 * (kStates - 1));
        EXPECT_EQ(poses.back().model_hash, std::int64_t(scene.model->hash));
    }
    if (GetParam().rings) {
        EXPECT_EQ(swung.back().count, 2);
        EXPECT_EQ(swung.back().seq, kStates - 1);
        EXPECT_EQ(swung.back().swung[1], target.said().q[1]);
        EXPECT_NE(swung.back().swung[0], 0.0F);
    }
    record->finish();
    replay(scene, folder / "bridge.csv", folder / "host.csv", true);
    EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
}

// What no servo of the scene says, whatever its CRC says.
TEST_P(BridgeOfEveryScene, WhatIsNoPoseOrNoModeIsRejected) {
    ASSERT_NO_FATAL_FAILURE(ask(0));
    publish(1);
    EXPECT_EQ(target.answer(true), 1);
    std::vector<std::function<void(haptable_line_answer&)>> faults;
    faults.emplace_back([this](haptable_line_answer& a) { a.out[fingers - 1].force_n[1] = std::nanf(""); });
    if (GetParam().is_free) {
        faults.emplace_back([](haptable_line_answer& a) { a.pose.position_m[2] = INFINITY; });
        faults.emplace_back([](haptable_line_answer& a) { a.pose.turn[0] = 0.5F; });
        faults.emplace_back([](haptable_line_answer& a) { a.pose.spin_rad_per_s[1] = std::nanf(""); });
    }
    if (GetParam().rings) faults.emplace_back([](haptable_line_answer& a) { a.q[1] = std::nanf(""); });
    const auto say = [this](const haptable_line_answer& answer) {
        port.put(frame_of(target.hello, answer, std::uint32_t(1 + fingers)));  // who begins first waits for nobody
        for (int tries = 0; tries < 100; ++tries) session.take_answers();
        handle_all(connection);
    };
    for (const auto& fault : faults) {
        haptable_line_answer wild = target.said();
        fault(wild);
        say(wild);
    }
    EXPECT_EQ(stepper.counters().rejected_forces, static_cast<std::int64_t>(faults.size()));
    EXPECT_FALSE(is_answered(1));
    say(target.said());
    EXPECT_TRUE(is_answered(1));
}

}  // namespace
}  // namespace haptable::test
