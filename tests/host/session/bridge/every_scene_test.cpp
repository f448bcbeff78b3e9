// SPDX-License-Identifier: GPL-2.0-or-later
// Every combination of fingers, free body and modes, a tool and hands behind a line: a session has the host's bits, and
// nothing reaches the device that no servo of the scene says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "host/link/messages.hpp"
#include "host/session/bridge/line_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/error_of.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/loop/every_scene.hpp"

namespace haptable::test {
namespace {

/// A terminal of the kernel's; fingers that come down on the body, slide and turn.
class BridgeOfEveryScene : public testing::TestWithParam<Parts> {
protected:
    BridgeOfEveryScene() {
        answered.fill(-1);
        for (std::size_t finger = 0; finger < fingers; ++finger)
            connection.subscribe<servo_force>(channel_of<servo_force>(finger),
                                              [this, finger](const servo_force& m, std::int64_t) {
                                                  answered[finger] = m.seq;
                                                  forces[finger] = m;
                                              });
        keep(poses);
        keep(swung);
        keep(wrenches);
    }
    template <typename Message>
    void keep(std::vector<Message>& all) {
        connection.subscribe<Message>(channel_of<Message>(),
                                      [&all](const Message& m, std::int64_t) { all.push_back(m); });
    }
    /// is_bad: a position that is no number, or a turn that is none.
    void publish(std::int64_t seq, bool is_bad = false) {
        const TargetState at = PathOfHands(9).at(static_cast<std::uint32_t>(seq));
        for (std::size_t finger = 0; finger < fingers; ++finger) {
            if (answered[finger] == seq) continue;
            device_state state = simulated_state(seq, seq * 1000);
            state.session += static_cast<std::int64_t>(finger);
            std::copy_n(at.in[finger].finger_m, 3, state.position_m);
            if (is_bad && scene.tool == nullptr) state.position_m[0] = NAN;
            if (scene.tool != nullptr) {
                hand_pose pose{};
                pose.seq = seq;
                pose.session = state.session;
                std::copy_n(at.turn.begin(), 4, pose.turn);
                if (is_bad) std::copy_n(std::array{0.5, 0.0, 0.0, 0.0}.begin(), 4, pose.turn);
                connection.publish(channel_of<hand_pose>(), pose);
            }
            connection.publish(channel_of<device_state>(finger), state);
        }
        handle_all(connection);
    }
    bool is_answered(std::int64_t seq) const {
        return std::all_of(answered.begin(), answered.begin() + static_cast<std::ptrdiff_t>(fingers),
                           [seq](std::int64_t last) { return last == seq; });
    }
    void ask(std::int64_t seq, bool is_bad = false) {
        const Clock::time_point give_up = Clock::now() + std::chrono::seconds(20);
        while (!is_answered(seq) && Clock::now() < give_up) {
            publish(seq, is_bad);
            target.answer();
            session.take_answers();
            session.watch(Clock::now());
            handle_all(connection);
        }
        ASSERT_TRUE(is_answered(seq)) << seq;
    }
    void press() {
        for (std::int64_t seq = 0; seq < 120; ++seq) ASSERT_NO_FATAL_FAILURE(ask(seq));
        ASSERT_EQ(int{forces[0].servo_state}, HAPTABLE_CONTACT);
    }
    /// What the target says comes by the kernel.
    void put(const Bytes& bytes) {
        port.put(bytes);
        for (int tries = 0; tries < 100; ++tries) session.take_answers();
        handle_all(connection);
    }

    const ServoScene scene = every_scene().scene(GetParam());
    const std::size_t fingers = fingers_of(scene);
    WorkFolder folder;
    const Pty port;
    Connection connection{"memq://"};
    SerialTarget line{Line::open(port.name(), 3'000'000), scene};
    FakeTarget<Pty> target{scene, port};
    std::optional<ServoRecord> record{std::in_place, scene, folder / "bridge.csv"};
    LineStepper stepper{line, {.retry = std::chrono::milliseconds(2)}};
    Session session{stepper, connection, &*record};
    std::array<std::int64_t, kFingers> answered{};
    std::array<servo_force, kFingers> forces{};
    std::vector<body_pose> poses;
    std::vector<body_modes> swung;
    std::vector<tool_wrench> wrenches;
};

INSTANTIATE_TEST_SUITE_P(Scenes, BridgeOfEveryScene, testing::ValuesIn(every_combination()),
                         [](const auto& of) { return of.param.name(); });

// Answers that are damaged are none, and asked for again; the record has the bytes of the host's replay, each point's
// contact too.
TEST_P(BridgeOfEveryScene, HasTheBitsOfTheHost) {
    constexpr std::int64_t kStates = 400;
    const std::int64_t ticks = fingers > 1 ? kStates + 1 : kStates;  // who begins first waits for nobody
    for (std::int64_t seq = 0; seq < kStates; ++seq) {
        if (seq % 100 == 50) target.damages = 3;
        ASSERT_NO_FATAL_FAILURE(ask(seq));
        for (std::size_t f = 0; f < fingers; ++f)
            for (int a = 0; a < 3; ++a) ASSERT_EQ(forces[f].force_n[a], double{target.output(f).force_n[a]}) << seq;
    }
    EXPECT_EQ(target.counters().ticks, std::uint32_t(ticks)) << "stepped once";
    EXPECT_GT(stepper.counters().contact_ticks, 50);
    EXPECT_GE(stepper.counters().resent_frames, 4) << "one of the damaged answers was a hello";
    EXPECT_EQ(stepper.counters().rejected_forces, 0);
    ASSERT_EQ(poses.size(), GetParam().is_free ? std::size_t(ticks) : 0U);
    ASSERT_EQ(swung.size(), GetParam().rings ? std::size_t(ticks) : 0U);
    ASSERT_EQ(wrenches.size(), GetParam().has_tool ? std::size_t(ticks) : 0U);
    if (GetParam().is_free) {
        EXPECT_EQ(poses.back().seq, kStates - 1);
        EXPECT_EQ(poses.back().session, kSession);
        EXPECT_EQ(poses.back().rest_centre_m[2], double{scene.body->centre_m[2]});
        EXPECT_EQ(poses.back().centre_m[0], double{target.said.body.position_m[0]});
        EXPECT_NE(poses.back().centre_m[0], poses[0].centre_m[0]) << "it is pushed";
        EXPECT_EQ(poses.back().velocity_m_per_s[0], double{target.said.body.velocity_m_per_s[0]});
        EXPECT_EQ(poses.back().turn[0], double{target.said.body.turn[0]});
        EXPECT_EQ(poses.back().utime, 1000 * (kStates - 1));
        EXPECT_EQ(poses.back().model_hash, std::int64_t(scene.model->hash));
    }
    if (GetParam().rings) {
        EXPECT_EQ(swung.back().count, 2);
        EXPECT_EQ(swung.back().seq, kStates - 1);
        EXPECT_EQ(swung.back().swung[1], target.said.modes.q[1]);
        EXPECT_NE(swung.back().swung[0], 0.0F);
    }
    double most_n_m = 0.0;
    for (const tool_wrench& wrench : wrenches) {
        ASSERT_EQ(wrench.count, 5);
        for (const double torque_n_m : wrench.torque_n_m) most_n_m = std::max(most_n_m, std::abs(torque_n_m));
    }
    EXPECT_EQ(most_n_m > 1e-5, GetParam().has_tool);
    EXPECT_GT(stepper.forces(0).energy.most_stored_j(), 0.0);
    record->finish();
    replay(scene, folder / "bridge.csv", folder / "host.csv", true);
    EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
}

// What no servo of the scene says does not reach the device, whatever its CRC says: here of the last finger, or a tool,
// that touches the first corner of the vertices 0, 1 and 2.
TEST_P(BridgeOfEveryScene, WhatIsNoAnswerOfTheSceneIsRejected) {
    const float nan = std::nanf("");
    ASSERT_NO_FATAL_FAILURE(ask(0));
    publish(1);
    for (int states = 0, tries = 0; states == 0 && tries < 1000; ++tries) states = target.answer(true);
    TargetAnswer touch = target.said;
    haptable_output& touching = touch.output[fingers - 1];
    touching = {};
    touching.state = HAPTABLE_CONTACT;
    touching.alpha[0] = 1.0F;
    for (std::uint16_t c = 0; c < 3; ++c) touching.vertex[c] = c;

    std::vector<std::function<void(TargetAnswer&)>> faults;
    const auto of_hand = [this, &faults](const std::function<void(haptable_output&)>& fault) {
        faults.emplace_back([this, fault](TargetAnswer& a) { fault(a.output[fingers - 1]); });
    };
    for (const float force_n : {2.0F * scene.model->max_force_n, nan, -INFINITY})
        of_hand([force_n](auto& o) { o.force_n[1] = force_n; });
    of_hand([](auto& o) { o.vertex[2] = 60000; });
    of_hand([nan](auto& o) { o.nodal_force_n[2][1] = nan; });
    of_hand([](auto& o) { o.god_object_m[0] = INFINITY; });
    of_hand([](auto& o) { o.alpha[1] = 0.5F; });
    of_hand([nan](auto& o) { o.alpha[1] = nan; });
    of_hand([](auto& o) { o.state = 200; });
    of_hand([](auto& o) {  // a dent that no body has
        o.state = HAPTABLE_FREE;
        o.vertex[1] = 60000;
    });
    for (const std::uint8_t state : {HAPTABLE_SILENT, HAPTABLE_FREE, HAPTABLE_REJECTED, HAPTABLE_FAULTED}) {
        if (state == HAPTABLE_FREE && scene.model->release != nullptr) continue;  // its force fades
        of_hand([state](auto& o) {
            o.state = state;
            o.force_n[2] = 0.1F;
        });
    }
    if (GetParam().is_free) {
        faults.emplace_back([](auto& a) { a.body.position_m[2] = INFINITY; });
        faults.emplace_back([](auto& a) { a.body.turn[0] = 0.5F; });
        faults.emplace_back([nan](auto& a) { a.body.spin_rad_per_s[1] = nan; });
    }
    if (GetParam().rings) faults.emplace_back([nan](auto& a) { a.modes.q[1] = nan; });
    if (GetParam().has_tool) {
        faults.emplace_back([nan](auto& a) { a.tool.out.torque_n_m[0] = nan; });
        faults.emplace_back([](auto& a) {  // out of contact
            a.output[0].state = HAPTABLE_FREE;
            a.tool.out.torque_n_m[2] = 1e-3F;
        });
        faults.emplace_back([](auto& a) { a.tool.out.position_m[1] = INFINITY; });
        faults.emplace_back([](auto& a) { a.tool.out.turn[0] = 0.5F; });
        faults.emplace_back([nan](auto& a) { a.tool.stored_j = nan; });
        // A sixth point; a patch that there is not; not within one; no number.
        const std::pair<std::size_t, haptable_line_point> points[] = {
            {5, {0, {1.0F, 0.0F, 0.0F}, {}, {}}},
            {0, {60000, {1.0F, 0.0F, 0.0F}, {}, {}}},
            {0, {0, {1.0F, 1.0F, 0.0F}, {}, {}}},
            {0, {0, {1.0F, 0.0F, 0.0F}, {}, {0.0F, nan, 0.0F}}}};
        for (const auto& [i, point] : points)
            faults.emplace_back([i = i, point = point](auto& a) {
                a.tool.inside = 1U << i;
                a.tool.point[i] = point;
            });
    }
    const auto say = [this](const TargetAnswer& answer) { put(frame_of(target.hello, answer, target.said.sequence)); };
    for (const auto& fault : faults) {
        TargetAnswer wild = touch;
        fault(wild);
        say(wild);
    }
    EXPECT_EQ(stepper.counters().rejected_forces, static_cast<std::int64_t>(faults.size()));
    EXPECT_FALSE(is_answered(1));
    say(touch);
    EXPECT_TRUE(is_answered(1));
}

// A tick whose pose or position is no number gives nothing.
TEST_P(BridgeOfEveryScene, ARejectedPoseHasNoForceAndNoTorque) {
    ASSERT_NO_FATAL_FAILURE(press());
    ASSERT_NO_FATAL_FAILURE(ask(120, true));
    for (std::size_t f = 0; f < fingers; ++f) {
        EXPECT_EQ(int{forces[f].servo_state}, HAPTABLE_REJECTED);
        for (const double force_n : forces[f].force_n) EXPECT_EQ(force_n, 0.0);
    }
    if (scene.tool != nullptr) {
        for (const double torque_n_m : wrenches.back().torque_n_m) EXPECT_EQ(torque_n_m, 0.0);
    }
    EXPECT_EQ(target.counters().rejected_positions, 1U);
}

TEST_P(BridgeOfEveryScene, ASilentHandHasNoForceAndNoTorque) {
    ASSERT_NO_FATAL_FAILURE(press());
    stepper.release(0);
    EXPECT_EQ(stepper.output(0).state, HAPTABLE_SILENT);
    for (const float force_n : stepper.output(0).force_n) EXPECT_EQ(force_n, 0.0F);
    if (scene.tool == nullptr) return;
    for (const float torque_n_m : stepper.tool()->torque_n_m) EXPECT_EQ(torque_n_m, 0.0F);
    for (const haptable_output& point : stepper.tool()->point) EXPECT_EQ(haptable_touches(point.state), 0);
}

// Before any state and after some: a board may be flashed while the bridge runs.
TEST_P(BridgeOfEveryScene, RefusesATargetOfAnotherSceneOrVersion) {
    const std::string tables = fmt::format(
        "the tables 000000000000004d, the folder's are {:016x}: build and flash it again", scene.model->hash);
    const std::pair<std::string, std::function<void(haptable_line_hello&)>> others[] = {
        {tables, [](auto& hello) { hello.hash = 77; }},
        {"version 9 of the line, this program version 3", [](auto& hello) { hello.version = 9; }},
        {"version 2 of the line, this program version 3", [](auto& hello) { --hello.version; }},
        {GetParam().has_tool ? "the target knows a tool" : "the target knows 7 fingers",
         [](auto& hello) { hello.fingers = 7; }},
        {"with 3 modes", [](auto& hello) { hello.modes = 3; }},
        {GetParam().is_free ? "a body that is held" : "a body that nothing holds",
         [](auto& hello) { hello.flags ^= HAPTABLE_LINE_FREE; }},
        {GetParam().has_tool ? "the target knows one finger" : "the target knows a tool",
         [](auto& hello) { hello.flags ^= HAPTABLE_LINE_TOOL; }},
        {"no error", [](auto&) {}},
    };
    for (int seq = 0; seq < 2; ++seq) {
        for (const auto& [error, change] : others) {
            haptable_line_hello other = target.hello;
            change(other);
            EXPECT_TRUE(fails_with([&] { put(frame_of(other)); }, error));
        }
        ASSERT_NO_FATAL_FAILURE(ask(seq));
    }
}

}  // namespace
}  // namespace haptable::test
