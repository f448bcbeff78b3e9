// SPDX-License-Identifier: GPL-2.0-or-later
// Whose servo it is, by a clock that the test holds.
#include "host/session/state_gate.hpp"

#include <gtest/gtest.h>

#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

using std::chrono::milliseconds;

constexpr std::int64_t kServo = 3, kTables = 1;

class StateGateTest : public testing::Test {
protected:
    /// A state of `session`, `ms` after the begin; it has just come.
    StateIs ask(std::int64_t session, std::int64_t seq, int ms, std::int64_t servo = 0) {
        device_state state = simulated_state(seq, 1000 * (seq + 1));
        state.session = session;
        state.servo = servo;
        state.mode = mode;
        if (stopped_us != 0) state.utime = stopped_us;
        return gate.judge(state, utime_now(), begin + milliseconds(ms));
    }

    std::int8_t mode = device_state::REAL_TIME;
    std::int64_t stopped_us = 0;  ///< where the device's clock stands still
    StateGate gate{kServo, kTables};
    const Clock::time_point begin = Clock::now();
};

TEST_F(StateGateTest, ADeviceHasTheServoUntilItIsSilent) {
    EXPECT_EQ(gate.owner(begin), 0);
    EXPECT_EQ(ask(7, 0, 0), StateIs::beginning);
    EXPECT_EQ(ask(8, 0, 1), StateIs::others);
    EXPECT_EQ(ask(7, 1, 15), StateIs::next);
    EXPECT_EQ(ask(8, 1, 34), StateIs::others);
    EXPECT_EQ(gate.owner(begin + milliseconds(34)), 7);
    EXPECT_EQ(gate.owner(begin + milliseconds(35)), 0);
    EXPECT_EQ(ask(8, 2, 35), StateIs::beginning);
    EXPECT_EQ(ask(7, 2, 36), StateIs::others) << "now it is the other's";
    EXPECT_EQ(gate.counters().other_device_states, 3);
    EXPECT_EQ(gate.counters().lost_states, 0);
}

// Who asks without end keeps nobody's servo: only its own states count.
TEST_F(StateGateTest, WhatIsRefusedKeepsNothing) {
    ask(7, 5, 0);
    for (int ms = 1; ms < 20; ++ms) {
        EXPECT_EQ(ask(7, 4, ms), StateIs::refused);
        EXPECT_EQ(ask(7, 5, ms), StateIs::repeated);
    }
    EXPECT_EQ(gate.owner(begin + milliseconds(20)), 0);
    EXPECT_EQ(gate.counters().old_states, 19);
    EXPECT_EQ(gate.counters().repeated_states, 19);
}

// A clock that stands still says nothing of when the finger was there: silence, however many states come.
TEST_F(StateGateTest, TimeThatDoesNotRunIsSilence) {
    stopped_us = 1'800'000'000'000'000;
    ask(7, 0, 0);
    for (int ms = 1; ms < 20; ++ms) EXPECT_EQ(ask(7, ms, ms), StateIs::refused);
    EXPECT_EQ(gate.owner(begin + milliseconds(20)), 0);
    EXPECT_EQ(gate.counters().stopped_states, 19);
}

TEST_F(StateGateTest, NumbersThatNeverCameAreLost) {
    for (const int seq : {2, 6, 7, 9}) EXPECT_NE(ask(7, seq, seq), StateIs::refused);
    EXPECT_EQ(gate.counters().lost_states, 4);
}

TEST_F(StateGateTest, AfterSilenceTheSameDeviceBeginsAnew) {
    ask(7, 5, 0);
    EXPECT_EQ(ask(7, 6, 19), StateIs::next);
    EXPECT_EQ(ask(7, 7, 39), StateIs::beginning);
    EXPECT_EQ(ask(7, 3, 60), StateIs::beginning) << "a clock or a count that was set back costs 20 ms";
    EXPECT_EQ(ask(7, 4, 61), StateIs::next);
}

TEST_F(StateGateTest, ADeviceThatHasLetGoBeginsAnew) {
    ask(7, 0, 0);
    EXPECT_EQ(ask(7, 1, 1, kServo), StateIs::next);
    EXPECT_EQ(ask(7, 2, 2, 0), StateIs::beginning);
    EXPECT_EQ(ask(7, 3, 3, kServo + 1), StateIs::refused);
    EXPECT_EQ(gate.counters().other_servo_states, 1);
}

// Simulated time stands still with its machine: the same device goes on when it does, another one may take the servo.
TEST_F(StateGateTest, InLockstepAStallChangesNothing) {
    mode = device_state::SIMULATED;
    ask(7, 0, 0);
    EXPECT_EQ(ask(8, 0, 999), StateIs::others);
    EXPECT_EQ(ask(7, 1, 3'600'000), StateIs::next);
    EXPECT_EQ(ask(7, 1, 3'600'900), StateIs::repeated);
    EXPECT_EQ(ask(8, 0, 3'601'800), StateIs::others);
    EXPECT_EQ(ask(8, 0, 3'601'900), StateIs::beginning);
}

TEST_F(StateGateTest, ASessionHasANameAndKeepsItsMode) {
    EXPECT_EQ(ask(0, 0, 0), StateIs::refused);
    for (const std::int8_t none : {std::int8_t{0}, std::int8_t{3}}) {
        mode = none;
        EXPECT_EQ(ask(7, 0, 0), StateIs::refused);
    }
    mode = device_state::REAL_TIME;
    EXPECT_EQ(ask(7, 0, 0), StateIs::beginning);
    mode = device_state::SIMULATED;
    EXPECT_EQ(ask(7, 1, 1), StateIs::refused);
    EXPECT_EQ(gate.counters().odd_states, 4);
}

}  // namespace
}  // namespace haptable::test
