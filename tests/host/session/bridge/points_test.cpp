// SPDX-License-Identifier: GPL-2.0-or-later
// A tool and hands behind a line: a session has the host's bits, and nothing reaches the device that no servo says.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "host/session/bridge/line_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/error_of.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/loop/points_line.hpp"

namespace haptable::test {
namespace {

class BridgeOfPoints : public testing::TestWithParam<LinePoints> {
protected:
    BridgeOfPoints() {
        for (std::size_t finger = 0; finger < fingers; ++finger)
            connection.subscribe<servo_force>(channel_of<servo_force>(finger),
                                              [this, finger](const servo_force& m, std::int64_t) {
                                                  answered[finger] = m.seq;
                                                  forces[finger] = m;
                                              });
        connection.subscribe<tool_wrench>(channel_of<tool_wrench>(),
                                          [this](const tool_wrench& m, std::int64_t) { wrenches.push_back(m); });
        pipes.put(end.begun);
    }
    /// is_bad: a position that is no number, or a turn that is none.
    void publish(std::int64_t seq, bool is_bad = false) {
        PointsPath path(9);
        const PointsState at = path.at(static_cast<std::uint32_t>(seq));
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
    /// What has come is answered; is_lost: the answer is not sent. How many states there were.
    int answer(bool is_lost = false) {
        int states = 0;
        for (const std::uint8_t byte : pipes.take()) {
            Bytes bytes = end.put(byte);
            if (bytes.empty()) continue;
            states += end.hear(bytes, said);
            if (damages > 0 && --damages >= 0) bytes[bytes.size() / 2] ^= 1;
            if (!is_lost) pipes.put(bytes);
        }
        return states;
    }
    void ask(std::int64_t seq, bool is_bad = false) {
        const Clock::time_point give_up = Clock::now() + std::chrono::seconds(20);
        while (!is_answered(seq) && Clock::now() < give_up) {
            publish(seq, is_bad);
            answer();
            session.take_answers();
            session.watch(Clock::now());
            handle_all(connection);
        }
        ASSERT_TRUE(is_answered(seq)) << seq;
    }
    /// As if the target had said that of state 1.
    void tell(const PointsAnswer& answer) {
        pipes.put(points_answer_frame(fingers > 1 ? 3 : 2, end.hello, answer));  // who begins first waits for nobody
        session.take_answers();
        handle_all(connection);
    }

    const ServoScene scene = PointsScene::of(GetParam()).scene();
    const std::size_t fingers = fingers_of(scene);
    WorkFolder folder;
    Pipes pipes;
    Connection connection{"memq://"};
    SerialTarget line{pipes.line(), scene};
    PointsEnd end{scene};
    PointsAnswer said;  ///< last
    int damages = 0;    ///< so many answers are to be damaged on their way
    ServoRecord record{scene, folder / "bridge.csv"};
    LineStepper stepper{line, {.retry = std::chrono::milliseconds(2)}};
    Session session{stepper, connection, &record};
    std::array<std::int64_t, kFingers> answered = [] {
        std::array<std::int64_t, kFingers> none{};
        none.fill(-1);
        return none;
    }();
    std::array<servo_force, kFingers> forces{};
    std::vector<tool_wrench> wrenches;
};

INSTANTIATE_TEST_SUITE_P(Scenes, BridgeOfPoints, testing::Values(LinePoints{0}, LinePoints{3}, LinePoints{8}),
                         [](const auto& of) { return of.param.name(); });

// Answers that are damaged are asked for again; the record has the bytes of the host's replay, each point's contact
// too.
TEST_P(BridgeOfPoints, HasTheBitsOfTheHost) {
    constexpr std::int64_t kStates = 400;
    for (std::int64_t seq = 0; seq < kStates; ++seq) {
        if (seq % 100 == 50) damages = 2;
        ASSERT_NO_FATAL_FAILURE(ask(seq));
        for (std::size_t f = 0; f < fingers; ++f) {
            const haptable_output& out = fingers == 1 ? said.tool.out.hand : said.hands.out[f];
            for (int a = 0; a < 3; ++a) ASSERT_EQ(forces[f].force_n[a], double{out.force_n[a]}) << seq;
        }
    }
    EXPECT_EQ(end.state.servo(0).counters.ticks, std::uint32_t(fingers > 1 ? kStates + 1 : kStates))
        << "who begins first waits for nobody, and each is stepped once";
    EXPECT_GT(stepper.counters().contact_ticks, 50);
    EXPECT_GE(stepper.counters().resent_frames, 4);
    EXPECT_EQ(stepper.counters().rejected_forces, 0);
    record.finish();
    replay(scene, folder / "bridge.csv", folder / "host.csv", true);
    EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
    if (scene.tool == nullptr) return;
    ASSERT_EQ(wrenches.size(), std::size_t(kStates));
    double most_n_m = 0.0;
    for (const tool_wrench& wrench : wrenches) {
        ASSERT_EQ(wrench.count, 5);
        for (const double torque_n_m : wrench.torque_n_m) most_n_m = std::max(most_n_m, std::abs(torque_n_m));
    }
    EXPECT_GT(most_n_m, 1e-5);
    EXPECT_GT(stepper.forces(0).energy.most_stored_j(), 0.0);
}

// What no servo of the scene says does not reach the device, whatever its CRC says.
TEST_P(BridgeOfPoints, WhatIsNoAnswerOfTheSceneIsRejected) {
    ASSERT_NO_FATAL_FAILURE(ask(0));
    publish(1);
    EXPECT_EQ(answer(true), 1);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::vector<std::function<void(PointsAnswer&)>> faults;
    const auto of_hand = [this, &faults](const std::function<void(haptable_output&)>& fault) {
        faults.emplace_back([this, fault](PointsAnswer& a) {
            fault(scene.tool != nullptr ? a.tool.out.hand : a.hands.out[fingers - 1]);
        });
    };
    of_hand([nan](haptable_output& o) { o.force_n[1] = nan; });
    of_hand([](haptable_output& o) { o.state = 200; });
    of_hand([](haptable_output& o) { o.force_n[0] = 1e3F; });
    if (scene.tool != nullptr) {
        const auto of_tool = [&faults](const std::function<void(haptable_tool_line_answer&)>& fault) {
            faults.emplace_back([fault](PointsAnswer& a) { fault(a.tool); });
        };
        of_tool([nan](auto& t) { t.out.torque_n_m[0] = nan; });
        of_tool([](auto& t) { t.out.torque_n_m[2] = 1e-3F; });  // out of contact
        of_tool([](auto& t) { t.out.position_m[1] = INFINITY; });
        of_tool([](auto& t) { t.out.turn[0] = 0.5F; });
        of_tool([nan](auto& t) { t.stored_j = nan; });
        of_tool([](auto& t) {  // a sixth point
            t.inside = 1U << 5;
            t.point[5] = {0, {1.0F, 0.0F, 0.0F}, {}, {}};
        });
        of_tool([](auto& t) {  // a patch that there is not
            t.inside = 1;
            t.point[0] = {60000, {1.0F, 0.0F, 0.0F}, {}, {}};
        });
        of_tool([](auto& t) {
            t.inside = 1;
            t.point[0] = {0, {1.0F, 1.0F, 0.0F}, {}, {}};
        });
        of_tool([nan](auto& t) {
            t.inside = 1;
            t.point[0] = {0, {1.0F, 0.0F, 0.0F}, {}, {0.0F, nan, 0.0F}};
        });
    }
    for (const auto& fault : faults) {
        PointsAnswer wild = said;
        fault(wild);
        tell(wild);
    }
    EXPECT_EQ(stepper.counters().rejected_forces, static_cast<std::int64_t>(faults.size()));
    EXPECT_FALSE(is_answered(1));
    tell(said);
    EXPECT_TRUE(is_answered(1));
}

// A tick whose pose or position is no number gives nothing, and the next one is felt.
TEST_P(BridgeOfPoints, ARejectedPoseHasNoForceAndNoTorque) {
    for (std::int64_t seq = 0; seq < 120; ++seq) ASSERT_NO_FATAL_FAILURE(ask(seq));
    EXPECT_EQ(int{forces[0].servo_state}, HAPTABLE_CONTACT);
    ASSERT_NO_FATAL_FAILURE(ask(120, true));
    for (std::size_t f = 0; f < fingers; ++f) {
        EXPECT_EQ(int{forces[f].servo_state}, HAPTABLE_REJECTED);
        for (const double force_n : forces[f].force_n) EXPECT_EQ(force_n, 0.0);
    }
    if (scene.tool != nullptr) {
        for (const double torque_n_m : wrenches.back().torque_n_m) EXPECT_EQ(torque_n_m, 0.0);
    }
    EXPECT_EQ(end.state.servo(0).counters.rejected_positions, 1U);
}

TEST_P(BridgeOfPoints, ASilentHandHasNoForceAndNoTorque) {
    for (std::int64_t seq = 0; seq < 120; ++seq) ASSERT_NO_FATAL_FAILURE(ask(seq));
    EXPECT_EQ(stepper.output(0).state, HAPTABLE_CONTACT);
    stepper.release(0);
    EXPECT_EQ(stepper.output(0).state, HAPTABLE_SILENT);
    for (const float force_n : stepper.output(0).force_n) EXPECT_EQ(force_n, 0.0F);
    if (scene.tool == nullptr) return;
    for (const float torque_n_m : stepper.tool()->torque_n_m) EXPECT_EQ(torque_n_m, 0.0F);
    for (const haptable_output& point : stepper.tool()->point) EXPECT_EQ(haptable_touches(point.state), 0);
}

// Another number of fingers, a finger in place of a tool, a board of before: told before any state is sent.
TEST_P(BridgeOfPoints, RefusesATargetOfAnotherScene) {
    const auto refused = [this](const std::function<void(haptable_line_hello&)>& change) {
        haptable_line_hello other = end.hello;
        change(other);
        pipes.put(frame_of(other));
        return error_of([&] { session.take_answers(); });
    };
    EXPECT_EQ(refused([](auto&) {}), "no error");
    EXPECT_TRUE(says(refused([](auto& hello) { hello.fingers = 7; }), "the target knows"));
    EXPECT_TRUE(says(refused([](auto& hello) { hello.flags ^= HAPTABLE_LINE_TOOL; }), "a tool of a body that is held"));
    EXPECT_TRUE(says(refused([](auto& hello) { --hello.version; }), "version 2 of the line, this program version 3"));
}

}  // namespace
}  // namespace haptable::test
