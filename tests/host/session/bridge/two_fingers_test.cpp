// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers of a target behind a line: ticks of both, and of one whose partner is late or gone.
#include <gtest/gtest.h>

#include <optional>

#include "host/session/bridge/line_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/finger.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/loop/soft_pair.hpp"

namespace haptable::test {
namespace {

using std::chrono::milliseconds;

const SoftPair& soft_pair() {
    static const SoftPair pair;
    return pair;
}

/// Two sides of the top, and how deep.
device_state state_at(std::size_t finger, std::int64_t seq, double depth_m, std::int8_t mode) {
    device_state state = simulated_state(seq, seq * 1000);
    state.session += static_cast<std::int64_t>(finger);
    state.mode = mode;
    state.position_m[0] = finger == 0 ? 0.0102 : 0.0197;
    state.position_m[1] = 0.0143;
    state.position_m[2] = 0.03 - depth_m;
    return state;
}

/// Time goes on, with what is due until then. A session that always has something due is an error, not a test for ever.
void leap(SimulatedTime& time, milliseconds ms) {
    const Clock::time_point until = time.now() + ms;
    for (int leaps = 0; time.now() < until; ++leaps) {
        if (leaps > 10 + 10 * ms.count()) throw std::runtime_error("the session's work is never done");
        time.leap(until);
    }
}

/// Real time that stands still but where a test lets it go on.
class BridgeOfTwo : public testing::Test {
protected:
    BridgeOfTwo() {
        time.also([this] { return session.watch_at(); },
                  [this](Clock::time_point now) {
                      session.watch(now);
                      exchange();
                  });
        for (std::size_t finger = 0; finger < kFingers; ++finger) {
            connection.subscribe<servo_force>(
                channel_of<servo_force>(finger),
                [this, finger](const servo_force& m, std::int64_t) { forces[finger].push_back(m); });
            connection.subscribe<contact>(channel_of<contact>(finger), [this, finger](const contact& m, std::int64_t) {
                contacts[finger].push_back(m);
            });
        }
        session.take_answers();  // its hello
    }

    void exchange() {
        if (answers_by_itself) target.answer();
        session.take_answers();
        handle_all(connection);
    }
    void send(std::size_t finger, std::int64_t seq, double depth_m, std::int8_t mode) {
        connection.publish(channel_of<device_state>(finger), state_at(finger, seq, depth_m, mode));
        handle_all(connection);
        exchange();
    }
    void lockstep(std::size_t finger, std::int64_t seq, double depth_m) {
        send(finger, seq, depth_m, device_state::SIMULATED);
    }
    void real(std::size_t finger, std::int64_t seq, double depth_m) {
        send(finger, seq, depth_m, device_state::REAL_TIME);
    }
    void wait(milliseconds ms) {
        leap(time, ms);
        exchange();
    }
    /// Both a millimetre deep, in real time, a tick ago: the next states are 20.
    void press_both() {
        for (std::int64_t seq = 0; seq < 20; ++seq) {
            for (std::size_t finger = 0; finger < kFingers; ++finger)
                real(finger, seq, 1e-4 * static_cast<double>(seq - 9));
            wait(milliseconds(1));
        }
        ASSERT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
        ASSERT_EQ(forces[1].back().servo_state, HAPTABLE_CONTACT);
    }

    SimulatedTime time;
    WorkFolder folder;
    Pipes pipes;
    Connection connection{"memq://"};
    SerialTarget line{pipes.line(), soft_pair().scene()};
    FakeTarget<Pipes> target{soft_pair().scene(), pipes};
    bool answers_by_itself = true;
    std::optional<ServoRecord> record{std::in_place, soft_pair().scene(), folder / "bridge.csv"};
    std::vector<std::string> told;
    LineStepper stepper{line, LineOptions{}};
    Session session{stepper, connection, &*record, [this](const std::string& text) { told.push_back(text); }};
    std::array<std::vector<servo_force>, kFingers> forces;
    std::array<std::vector<contact>, kFingers> contacts;
};

// Whoever comes first; its record is the host's servo's, byte for byte, of what was alone and of what was a pair.
TEST_F(BridgeOfTwo, InLockstepATickIsBothAndItsForcesAreTheHosts) {
    for (std::int64_t seq = 0; seq < 5; ++seq) lockstep(0, seq, 1e-4 * static_cast<double>(seq - 10));
    EXPECT_TRUE(forces[1].empty());
    lockstep(1, 0, -0.001);
    ASSERT_EQ(forces[1].size(), 1U);
    for (std::int64_t seq = 5; seq < 60; ++seq) {
        const std::size_t first = static_cast<std::size_t>(seq % 2);
        const double depth_m = 1e-4 * static_cast<double>(seq - 10);
        lockstep(first, seq, depth_m);
        ASSERT_EQ(forces[first].back().seq, first == 1 && seq == 5 ? 0 : seq - 1) << "it waits for the other";
        lockstep(1 - first, seq, depth_m);
        for (std::size_t finger = 0; finger < kFingers; ++finger) {
            ASSERT_EQ(forces[finger].back().seq, seq);
            EXPECT_EQ(forces[finger].back().utime, forces[0].back().utime);
            EXPECT_EQ(contacts[finger].back().seq, seq);
        }
    }
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_GT(forces[1].back().force_n[2], 0.0);
    EXPECT_EQ(contacts[1].back().count, 3);
    EXPECT_EQ(stepper.counters(1).ticks, 56);
    EXPECT_EQ(stepper.counters(1).contact_ticks, stepper.counters(0).contact_ticks);
    EXPECT_EQ(stepper.counters().stale_answers + stepper.counters().lost_answers + stepper.counters().resent_frames, 0);
    record->finish();
    replay(soft_pair().scene(), folder / "bridge.csv", folder / "host.csv", true);
    EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
}

TEST_F(BridgeOfTwo, OneDeviceFeelsWhatASceneOfOneGives) {
    const ServoScene one = soft_pair().scene_of_one();
    haptable_servo servo;
    haptable_servo_init(&servo);
    check_tables(*one.model, servo);
    for (std::int64_t seq = 0; seq < 30; ++seq) {
        const double depth_m = 1e-4 * static_cast<double>(seq - 10);
        lockstep(0, seq, depth_m);
        haptable_output out;
        const device_state at = state_at(0, seq, depth_m, device_state::SIMULATED);
        haptable_servo_step(one.model, &servo, to_finger(at.position_m).data(), static_cast<std::uint32_t>(seq * 1000),
                            &out);
        ASSERT_EQ(forces[0].size(), static_cast<std::size_t>(seq) + 1);
        for (int a = 0; a < 3; ++a) ASSERT_EQ(forces[0].back().force_n[a], double{out.force_n[a]});
    }
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_EQ(target.counters(1).ticks, 0U);
}

TEST_F(BridgeOfTwo, InRealTimeAForceThatIsLostIsOvertaken) {
    press_both();
    const std::size_t answers = forces[0].size();
    const std::uint32_t ticks = target.counters(0).ticks;
    answers_by_itself = false;
    real(0, 20, 0.0011);
    real(1, 20, 0.0011);
    EXPECT_EQ(target.answer(true), 1);
    exchange();
    EXPECT_EQ(forces[0].size(), answers);
    real(0, 21, 0.0011);
    real(1, 21, 0.0011);
    session.watch(Clock::now() + std::chrono::milliseconds(10));  // longer than the answer is waited for
    EXPECT_EQ(target.answer(), 1);
    exchange();
    EXPECT_EQ(forces[0].size(), answers + 1);
    EXPECT_EQ(forces[1].back().seq, 21);
    EXPECT_EQ(target.counters(0).ticks, ticks + 2);
    EXPECT_EQ(stepper.counters(0).lost_answers, 1);
    EXPECT_EQ(stepper.counters(1).lost_answers, 1);
}

TEST_F(BridgeOfTwo, InLockstepATickIsSentAgainUntilItIsAnswered) {
    lockstep(0, 0, -0.001);
    lockstep(1, 0, -0.001);
    answers_by_itself = false;
    const std::uint32_t ticks = target.counters(0).ticks;
    lockstep(0, 1, -0.001);
    lockstep(1, 1, -0.001);
    target.answer(true);
    exchange();
    EXPECT_EQ(forces[0].back().seq, 0);
    wait(milliseconds(50));
    EXPECT_EQ(target.answer(), 1);
    exchange();
    EXPECT_EQ(forces[0].back().seq, 1);
    EXPECT_EQ(forces[1].back().seq, 1);
    EXPECT_EQ(target.counters(0).ticks, ticks + 1);
    EXPECT_EQ(stepper.counters().resent_frames, 1);
}

TEST_F(BridgeOfTwo, AStateWaitsAMillisecondForTheOthersAndNotAgain) {
    press_both();
    const std::size_t before = forces[0].size(), others = forces[1].size();
    real(0, 20, 0.0011);
    EXPECT_EQ(forces[0].size(), before) << "it waits";
    wait(milliseconds(1));
    ASSERT_EQ(forces[0].size(), before + 1);
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_EQ(forces[1].size(), others) << "who did not ask has no answer";
    EXPECT_EQ(target.output(1).state, HAPTABLE_CONTACT) << "it is where it was";
    real(0, 21, 0.0011);
    EXPECT_EQ(forces[0].size(), before + 2) << "nobody waits again for who was late";
}

TEST_F(BridgeOfTwo, ASilentFingerIsReleasedAndTheOtherGoesOn) {
    press_both();
    const double both_n = forces[0].back().force_n[2];
    const std::size_t answers = forces[1].size();
    for (std::int64_t seq = 20; seq < 45; ++seq) {
        real(0, seq, 0.001);
        wait(milliseconds(1));
    }
    ASSERT_EQ(forces[1].size(), answers + 1) << "told once";
    EXPECT_EQ(forces[1].back().servo_state, HAPTABLE_SILENT);
    EXPECT_EQ(contacts[1].back().count, 0);
    EXPECT_EQ(forces[0].back().seq, 44);
    EXPECT_GT(forces[0].back().force_n[2], 1.02 * both_n) << "nothing takes the surface away any more";
    EXPECT_EQ(target.output(1).state, HAPTABLE_SILENT);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("finger 2: contact dropped after a silence of 20 ms"), std::string::npos) << told[0];
    // Another device for it, inside: it feels nothing, and the first goes on in its contact.
    device_state again = state_at(1, 0, 0.001, device_state::REAL_TIME);
    again.session = 77;
    connection.publish(channel_of<device_state>(1), again);
    handle_all(connection);
    exchange();
    EXPECT_EQ(forces[1].back().session, 77);
    EXPECT_EQ(forces[1].back().servo_state, HAPTABLE_FREE);
    EXPECT_EQ(target.output(0).state, HAPTABLE_CONTACT);
}

TEST(BridgeOfOne, ASecondDeviceIsToldThatTheSceneHasOneFinger) {
    const SoftBox box;
    const Pipes pipes;
    Connection connection("memq://");
    SerialTarget line(pipes.line(), box.scene());
    std::vector<std::string> told;
    LineStepper stepper(line, {});
    Session session(stepper, connection, nullptr, [&](const std::string& text) { told.push_back(text); });
    connection.publish(channel_of<device_state>(1), simulated_state(0, 0));
    handle_all(connection);
    session.publish_status();
    EXPECT_TRUE(pipes.take().empty());
    EXPECT_EQ(session.link_report().absent_finger_states, 1);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("fingers = 2"), std::string::npos) << told[0];
}

// A terminal of the kernel's in the pipes' place.
TEST(BridgeOfTwoOverAPort, BothAreAnswered) {
    const Pty port;
    Connection connection("memq://");
    SerialTarget line(Line::open(port.name(), 2'000'000), soft_pair().scene());
    FakeTarget target(soft_pair().scene(), port);
    LineStepper stepper(line, {});
    Session session(stepper, connection, nullptr);
    std::array<std::int64_t, kFingers> seq{-1, -1};
    for (std::size_t finger = 0; finger < kFingers; ++finger)
        connection.subscribe<servo_force>(channel_of<servo_force>(finger),
                                          [&, finger](const servo_force& m, std::int64_t) { seq[finger] = m.seq; });
    const Clock::time_point give_up = Clock::now() + std::chrono::seconds(20);
    for (std::int64_t tick = 0; tick < 20; ++tick)
        while ((seq[0] != tick || seq[1] != tick) && Clock::now() < give_up) {
            for (std::size_t finger = 0; finger < kFingers; ++finger)
                if (seq[finger] != tick)
                    connection.publish(
                        channel_of<device_state>(finger),
                        state_at(finger, tick, 1e-4 * static_cast<double>(tick - 5), device_state::SIMULATED));
            handle_all(connection);
            target.answer();
            session.take_answers();
            session.watch(Clock::now());
            handle_all(connection);
        }
    EXPECT_EQ(seq, (std::array<std::int64_t, kFingers>{19, 19}));
    EXPECT_EQ(target.output(0).state, HAPTABLE_CONTACT);
    EXPECT_EQ(target.output(1).state, HAPTABLE_CONTACT);
    EXPECT_EQ(line.skipped_bytes(), 0U);
}

}  // namespace
}  // namespace haptable::test
