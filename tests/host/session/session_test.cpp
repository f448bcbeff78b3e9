// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's side of the loop, asked by hand, its ticks computed here and behind a line. Which states are ticks
// state_gate_test.cpp says; what two devices have of one session tests/loop/two_fingers_test.cpp.
#include "host/session/session.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "tests/error_of.hpp"
#include "tests/loop/asked_session.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;

constexpr double kOutside_m = -0.001, kInside_m = 0.002;  // deep
constexpr std::int64_t kOther = 5;                        // another device's session

class OneFinger : public AskedSession, public testing::TestWithParam<bool> {
protected:
    OneFinger() : AskedSession(soft_pair().scene_of_one(), GetParam()) {}
    /// From outside in, in real time.
    void touch() {
        real(0, 0, kOutside_m);
        real(0, 1, kInside_m);
        ASSERT_EQ(int{forces[0].back().servo_state}, HAPTABLE_CONTACT);
    }

    const std::int64_t hash = static_cast<std::int64_t>(scene.model->hash);
};
INSTANTIATE_TEST_SUITE_P(Behind, OneFinger, testing::Bool(), name_of_place);

// Pressed and lifted on the same way, what is stored comes back, but for what a sampled spring gives in its ticks.
TEST_P(OneFinger, StatusTellsTheEnergies) {
    const auto nanojoules = [this](const char* name) { return double(status(name)); };
    for (std::int64_t seq = 0; seq <= 100; ++seq) lockstep(0, seq, 4e-5 * double(seq) - 1e-4);
    const double stored_nj = nanojoules("energy_stored_nj");
    const contact& pressed = contacts[0].back();
    double work_nj = 0.0;  // 1/2 u . f
    for (const auto& force_n : pressed.force_n)
        work_nj += 0.5e9 * Vector3d(force_n.data()).dot(Vector3d(pressed.finger_m) - Vector3d(pressed.god_object_m));
    EXPECT_GT(stored_nj, 1000.0);
    // u is 4 mm, a difference of positions in float; the status has whole nanojoules.
    EXPECT_WITHIN(std::abs(work_nj - stored_nj) - 0.5, .count = 16, .epsilon = kFloat, .condition = 0.03 / 0.004,
                  .size = stored_nj);
    EXPECT_LT(nanojoules("energy_given_nj"), -0.5 * stored_nj);
    for (std::int64_t seq = 101; seq <= 202; ++seq) lockstep(0, seq, 4e-5 * double(200 - seq) - 1e-4);
    EXPECT_EQ(nanojoules("energy_stored_nj"), 0.0);
    EXPECT_EQ(nanojoules("energy_most_stored_nj"), stored_nj);
    EXPECT_WITHIN(std::abs(nanojoules("energy_given_nj") - 2.0 * stored_nj / 100.0), .epsilon = 0.02,
                  .size = stored_nj);
    EXPECT_LE(std::abs(stepper->forces(0).energy.most_stored_j() * 1e9 - stored_nj), 0.5) << "rounded to a whole nJ";
}

// The forces on the nodes are the finger's action, the user's force is their reaction (eq. 12).
TEST_P(OneFinger, ContactMessageCarriesTheLoad) {
    touch();
    EXPECT_EQ(contacts[0][0].count, 0);
    const contact& touched = contacts[0].back();
    ASSERT_EQ(touched.count, 3);
    EXPECT_EQ(touched.seq, 1);
    EXPECT_EQ(touched.model_hash, hash);
    EXPECT_EQ(touched.finger_m[2], 0.03 - kInside_m);
    EXPECT_WITHIN(std::abs(touched.god_object_m[2] - 0.03), .count = 16, .epsilon = kFloat, .size = 0.03);
    Vector3d sum = Vector3d(forces[0].back().force_n);
    for (const auto& force_n : touched.force_n) sum += Vector3d(force_n.data());
    EXPECT_WITHIN(sum.norm(), .count = 16, .epsilon = kFloat);
    for (const std::int32_t node : touched.node)  // mesh nodes of the top
        EXPECT_GT(soft_pair().tables().position.at(std::size_t(node))[2], 0.0299);
}

TEST(SessionsStatus, NamesEveryCounterOfTheFirmware) {
    AskedSession asked(soft_pair().scene_of_one(), false);
    asked.lockstep(0, 0, kOutside_m);
    asked.time.reset();  // a step takes some
    asked.lockstep(0, 1, kInside_m);
#define HAPTABLE_CHECK(name) EXPECT_GE(asked.status(#name), 0);
    HAPTABLE_COUNTERS(HAPTABLE_CHECK)
#undef HAPTABLE_CHECK
    EXPECT_EQ(asked.status("contacts"), 1);
    EXPECT_EQ(asked.statuses[0].servo_state, HAPTABLE_CONTACT);
    EXPECT_EQ(asked.statuses[0].model_hash, std::int64_t(asked.scene.model->hash));
    EXPECT_GT(asked.statuses[0].longest_step_us, 0.0);
    EXPECT_EQ(asked.statuses[1].longest_step_us, 0.0);  // since the last status
}

// In real time: zero force, said once, and not before the 20 ms are over; told where it drops a contact.
TEST_P(OneFinger, FallsSilentWithoutStates) {
    real(0, 0, kOutside_m);
    wait(milliseconds(30));
    EXPECT_EQ(told, std::vector<std::string>{}) << "there was no contact";
    forces[0].clear();
    ASSERT_NO_FATAL_FAILURE(touch());
    EXPECT_EQ(session->watch_at() - session->last_state(), milliseconds(20));
    wait(milliseconds(19));
    ASSERT_EQ(forces[0].size(), 2U);
    for (const int ms : {2, 1, 60'000}) wait(milliseconds(ms));
    ASSERT_EQ(forces[0].size(), 3U);
    expect_no_force(HAPTABLE_SILENT);
    EXPECT_EQ(forces[0][2].seq, 1);
    EXPECT_EQ(contacts[0].back().count, 0);
    EXPECT_EQ(session->watch_at(), Clock::time_point::max());
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "contact dropped after a silence of 20 ms"));
}

// The finger that is there was never seen to come: no force until it has been outside. In lockstep no time has passed.
TEST_P(OneFinger, AReplacedDeviceInheritsNoContact) {
    time->also({}, {});  // nobody watches
    for (const std::int8_t mode : {device_state::REAL_TIME, device_state::SIMULATED}) {
        for (const std::int64_t seq : {0, 1}) send(0, state(0, seq, seq == 0 ? kOutside_m : kInside_m, mode));
        ASSERT_EQ(int{forces[0].back().servo_state}, HAPTABLE_CONTACT);
        wait(mode == device_state::SIMULATED ? std::chrono::seconds(1) : milliseconds(21));
        for (const std::int64_t seq : {2, 3}) {
            device_state others = state(0, seq, kInside_m, mode);
            others.session = kOther;
            send(0, others);
            EXPECT_EQ(forces[0].back().session, kOther);
            EXPECT_EQ(forces[0].back().owner, kOther);
            expect_no_force(HAPTABLE_FREE);
        }
        wait(milliseconds(21));
    }
    EXPECT_EQ(status("lost_states"), 0);
}

TEST_P(OneFinger, TwoServosHaveTwoNames) {
    lockstep(0, 0, kOutside_m);
    LocalStepper other_stepper(scene);
    Session other(other_stepper, connection, nullptr);
    lockstep(0, 1, kOutside_m);  // both answer who belongs to none
    ASSERT_EQ(forces[0].size(), 3U);
    EXPECT_NE(forces[0][2].servo, forces[0][1].servo);
    const std::int64_t others = forces[0][1].servo == forces[0][0].servo ? forces[0][2].servo : forces[0][1].servo;
    device_state theirs = state(0, 2, kOutside_m, device_state::SIMULATED);
    theirs.servo = others;
    send(0, theirs);
    ASSERT_EQ(forces[0].size(), 4U);
    EXPECT_EQ(forces[0][3].servo, others);
    EXPECT_EQ(status("other_servo_states"), 1);
}

// After a stall the finger is where the newest state says; what it did meanwhile is over. In lockstep each is a tick.
TEST_P(OneFinger, OfStatesThatWaitTheNewestIsTaken) {
    if (!behind) {
        std::vector<device_state> states;
        for (int seq = 0; seq < 3; ++seq) states.push_back(state(0, seq, -5e-4, device_state::SIMULATED));
        send(0, states);
        EXPECT_EQ(forces[0].size(), 3U);
        EXPECT_EQ(status("skipped_states"), 0);
        wait(std::chrono::seconds(2));
        forces[0].clear();
    }
    send(0, real_state(0, kOutside_m, kOther));
    send(0, {real_state(1, -2e-4, kOther), real_state(2, -1e-4, kOther), real_state(3, 1e-4, kOther)});
    ASSERT_EQ(forces[0].size(), 2U);
    EXPECT_EQ(forces[0].back().seq, 3);
    EXPECT_EQ(contacts[0].back().finger_m[2], 0.0299);
    EXPECT_EQ(status("skipped_states"), 2);
    EXPECT_EQ(status("ticks"), behind ? 2 : 5);
    EXPECT_EQ(status("lost_states"), 0);
}

TEST_P(OneFinger, AStateThatWaited20MsIsNone) {
    real(0, 0, kOutside_m);
    time.reset();  // how long a message waits liblcm says by the machine's clock
    connection.publish(channel_of<device_state>(), real_state(1, 0.0));
    std::this_thread::sleep_for(milliseconds(21));
    handle_all(connection);
    EXPECT_EQ(forces[0].size(), 1U);
    EXPECT_EQ(status("late_states"), 1);
}

// A user who looks at the servo's terminal reads who else is there, once, and nothing of a session that goes well.
// States of another model are refused.
TEST_P(OneFinger, TellsWhoElseIsOnTheChannelOnce) {
    const auto ask = [this](std::int64_t seq, std::int64_t model_hash) {
        device_state ours = state(0, seq, kOutside_m, device_state::SIMULATED);
        ours.model_hash = model_hash;
        send(0, ours);
    };
    for (std::int64_t seq = 0; seq < 20; ++seq) ask(seq, seq % 2 == 0 ? hash : 0);
    session->publish_status();
    EXPECT_EQ(told, std::vector<std::string>{});
    ASSERT_EQ(forces[0].size(), 20U);
    device_state theirs = state(0, 0, kInside_m, device_state::SIMULATED), other_servos = theirs;
    theirs.session = kOther;
    other_servos.servo = 77;
    for (std::int64_t seq = 20; seq < 40; ++seq) {
        ask(seq, hash + 1);
        send(0, {theirs, other_servos});
        session->publish_status();
    }
    EXPECT_EQ(status("foreign_states"), 20);
    EXPECT_EQ(status("ticks"), 20);
    ASSERT_EQ(told.size(), 3U);
    EXPECT_TRUE(says(told[0], "a device of another scene"));
    EXPECT_TRUE(says(told[1], "a second servo is on the channel"));
    EXPECT_TRUE(says(told[2], "a second device is on the channel"));
}

TEST_P(OneFinger, AFingerThatTheSceneHasNotIsToldAndNotAnswered) {
    for (int twice = 0; twice < 2; ++twice) {
        send(1, simulated_state(twice, 1000 * twice));
        session->publish_status();
    }
    EXPECT_TRUE(forces[0].empty() && forces[1].empty());
    EXPECT_EQ(session->link_report().absent_finger_states, 2);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "fingers = 2"));
}

// A position that is none gives no force, and drops the contact.
TEST_P(OneFinger, TellsThatPositionsLookLikeMillimetres) {
    ASSERT_NO_FATAL_FAILURE(touch());
    device_state in_mm = real_state(2, kInside_m);
    for (double& coordinate : in_mm.position_m) coordinate *= 1000.0;
    send(0, in_mm);
    expect_no_force(HAPTABLE_REJECTED);
    EXPECT_EQ(contacts[0].back().count, 0);
    session->publish_status();
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "position 10.2 14.3 28 m rejected"));
    EXPECT_TRUE(says(told[0], "looks like millimetres"));
}

}  // namespace
}  // namespace haptable::test
