// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's side of the loop over memq://, asked by hand.
#include "host/session/session.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <thread>

#include "host/session/local_stepper.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

constexpr std::int64_t kHash = 1;  // of the test's model

constexpr double kAbove_m = 0.031, kInside_m = 0.028;

class ServoSessionTest : public testing::Test {
protected:
    ServoSessionTest()
        : session(stepper, connection, nullptr, [this](const std::string& line) { told.push_back(line); }) {
        collect(forces);
        collect(contacts);
        collect(statuses);
    }
    template <typename Message>
    void collect(std::vector<Message>& into) {
        connection.subscribe<Message>(channel_of<Message>(),
                                      [&into](const Message& message, std::int64_t) { into.push_back(message); });
    }

    /// One state in simulated time, and what comes of it.
    void ask(std::int64_t seq, double z, std::int64_t model_hash = 0) {
        device_state asked = state(seq, z);
        asked.model_hash = model_hash;
        send({asked});
    }
    /// A device's next state, a millisecond after the last.
    static device_state state(std::int64_t seq, double z, std::int64_t session = kSession) {
        device_state state = simulated_state(seq, seq * 1000);
        state.session = session;
        state.position_m[0] = 0.0131;
        state.position_m[1] = 0.0112;
        state.position_m[2] = z;
        return state;
    }
    /// The same in real time, by the clock of a device of its own.
    static device_state real_state(std::int64_t seq, double z, std::int64_t session = kSession) {
        device_state real = state(seq, z, session);
        real.mode = device_state::REAL_TIME;
        real.utime += 1'800'000'000'000'000;
        return real;
    }
    /// States that come at once.
    void send(const std::vector<device_state>& states) {
        for (const device_state& one : states) connection.publish(channel_of<device_state>(), one);
        handle_all(connection);
    }
    /// The states 0 and 1: the finger comes from outside, and touches.
    void touch() {
        ask(0, kAbove_m);
        ask(1, kInside_m);
    }
    void touch_in_real_time(std::int64_t first = 0) {
        send({real_state(first, kAbove_m)});
        send({real_state(first + 1, kInside_m)});
        ASSERT_EQ(forces.back().servo_state, HAPTABLE_CONTACT);
    }
    /// So long after the last state.
    void watch_after(int ms) {
        session.watch(session.last_state() + std::chrono::milliseconds(ms));
        handle_all(connection);
    }
    std::int64_t status(const std::string& name) {
        session.publish_status();
        handle_all(connection);
        const servo_status& last = statuses.back();
        for (std::size_t i = 0; i < last.name.size(); ++i)
            if (last.name[i] == name) return last.value[i];
        ADD_FAILURE() << "no counter is called " << name;
        return -1;
    }
    /// The last answer has no force.
    void expect_no_force(std::int8_t servo_state) const {
        EXPECT_EQ(forces.back().servo_state, servo_state);
        for (const double component : forces.back().force_n) EXPECT_EQ(component, 0.0);
    }

    // What 20 ms of silence do must not hang on how busy this machine is.
    std::optional<SimulatedTime> time{std::in_place};
    SoftBox box;
    Connection connection{"memq://"};
    std::vector<std::string> told;  ///< events, a line each
    LocalStepper stepper{box.scene()};
    Session session;
    std::vector<servo_force> forces;
    std::vector<contact> contacts;
    std::vector<servo_status> statuses;
};

// Pressed and lifted on the same way, what is stored comes back, but for what a sampled spring gives in its ticks.
TEST_F(ServoSessionTest, StatusTellsTheEnergies) {
    const auto nanojoules = [this](const char* name) { return double(status(name)); };
    for (std::int64_t seq = 0; seq <= 100; ++seq) ask(seq, 0.0301 - 4e-5 * double(seq));
    const double stored_nj = nanojoules("energy_stored_nj");
    double work_nj = 0.0;  // 1/2 u . f
    for (const auto& force_n : contacts.back().force_n)
        for (std::size_t a = 0; a < 3; ++a)
            work_nj += 0.5e9 * force_n[a] * (contacts.back().finger_m[a] - contacts.back().god_object_m[a]);
    EXPECT_GT(stored_nj, 1000.0);
    // u is 4 mm, a difference of positions in float; the status has whole nanojoules.
    EXPECT_WITHIN(std::abs(work_nj - stored_nj) - 0.5, .count = 16, .epsilon = kFloat, .condition = 0.03 / 0.004,
                  .size = stored_nj);
    EXPECT_LT(nanojoules("energy_given_nj"), -0.5 * stored_nj);
    for (std::int64_t seq = 101; seq <= 202; ++seq) ask(seq, 0.0301 - 4e-5 * double(200 - seq));
    EXPECT_EQ(nanojoules("energy_stored_nj"), 0.0);
    EXPECT_EQ(nanojoules("energy_most_stored_nj"), stored_nj);
    EXPECT_WITHIN(std::abs(nanojoules("energy_given_nj") - 2.0 * stored_nj / 100.0), .epsilon = 0.02,
                  .size = stored_nj);
    EXPECT_LE(std::abs(stepper.report().energy.most_stored_j() * 1e9 - stored_nj), 0.5) << "rounded to a whole nJ";
}

// The forces on the nodes are the finger's action, the user's force is their reaction (eq. 12).
TEST_F(ServoSessionTest, ContactMessageCarriesTheLoad) {
    touch();
    EXPECT_EQ(contacts[0].count, 0);
    const contact& touched = contacts.back();
    ASSERT_EQ(touched.count, 3);
    EXPECT_EQ(touched.seq, 1);
    EXPECT_EQ(touched.model_hash, kHash);
    EXPECT_EQ(touched.finger_m[2], kInside_m);
    EXPECT_WITHIN(std::abs(touched.god_object_m[2] - 0.03), rounded(box.model()));
    for (std::size_t a = 0; a < 3; ++a) {
        double sum = 0.0;
        for (const auto& force_n : touched.force_n) sum += force_n[a];
        EXPECT_WITHIN(std::abs(sum + forces.back().force_n[a]), .count = 16, .epsilon = kFloat);
    }
    for (const std::int32_t node : touched.node)  // mesh nodes of the top
        EXPECT_GT(box.model().tables().position[std::size_t(node)][2], 0.0299);
}

TEST_F(ServoSessionTest, StatusNamesEveryCounterOfTheFirmware) {
    ask(0, kAbove_m);
    time.reset();  // a step takes some
    ask(1, kInside_m);
#define HAPTABLE_CHECK(name) EXPECT_GE(status(#name), 0);
    HAPTABLE_COUNTERS(HAPTABLE_CHECK)
#undef HAPTABLE_CHECK
    EXPECT_EQ(status("contacts"), 1);
    EXPECT_EQ(statuses[0].servo_state, HAPTABLE_CONTACT);
    EXPECT_EQ(statuses[0].model_hash, kHash);
    EXPECT_GT(statuses[0].longest_step_us, 0.0);
    EXPECT_EQ(statuses[1].longest_step_us, 0.0);  // since the last status
}

TEST_F(ServoSessionTest, BadPositionGivesZeroForceAndDropsTheContact) {
    touch();
    ask(2, std::numeric_limits<double>::quiet_NaN());
    expect_no_force(HAPTABLE_REJECTED);
    EXPECT_EQ(contacts.back().count, 0);
    EXPECT_EQ(status("rejected_positions"), 1);
}

// In real time: zero force, said once, and not before the 20 ms are over; told where it drops a contact.
TEST_F(ServoSessionTest, FallsSilentWithoutStates) {
    send({real_state(0, kAbove_m)});
    watch_after(30);
    EXPECT_EQ(told, std::vector<std::string>{}) << "there was no contact";
    forces.clear();
    ASSERT_NO_FATAL_FAILURE(touch_in_real_time(100));
    EXPECT_EQ(session.watch_at() - session.last_state(), std::chrono::milliseconds(20));
    watch_after(19);
    ASSERT_EQ(forces.size(), 2U);
    // The firmware's clock began with the step, a little after the state came.
    for (const int ms : {60'000, 60'001, 60'002}) watch_after(ms);
    ASSERT_EQ(forces.size(), 3U);
    expect_no_force(HAPTABLE_SILENT);
    EXPECT_EQ(forces[2].seq, 101);
    EXPECT_EQ(contacts.back().count, 0);
    EXPECT_EQ(session.watch_at(), Clock::time_point::max());
    EXPECT_EQ(status("silences"), 2);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "contact dropped after a silence of 60000 ms"));
}

TEST_F(ServoSessionTest, SimulatedTimeStandsStillBetweenStates) {
    touch();
    watch_after(3'600'000);
    EXPECT_EQ(forces.size(), 2U);
    EXPECT_EQ(status("silences"), 0);
}

// ---- whose servo it is ---------------------------------------------------------------------------------------------

TEST_F(ServoSessionTest, ASecondDeviceGetsNoForceAndIsTold) {
    touch();
    const std::size_t before = contacts.size();
    send({state(0, 0.029, 5)});
    ASSERT_EQ(forces.size(), 3U);
    EXPECT_EQ(forces[2].session, 5);
    EXPECT_EQ(forces[2].owner, kSession);
    expect_no_force(HAPTABLE_SILENT);
    ask(2, 0.027);
    ASSERT_EQ(forces.size(), 4U);
    EXPECT_EQ(forces[3].session, kSession);
    EXPECT_EQ(forces[3].owner, kSession);
    EXPECT_EQ(forces[3].servo_state, HAPTABLE_CONTACT) << "its contact is as it was";
    EXPECT_EQ(contacts.size(), before + 1);
    EXPECT_EQ(status("other_device_states"), 1);
    EXPECT_EQ(statuses.back().session, kSession);
    EXPECT_EQ(statuses.back().servo, forces[3].servo);
}

// The finger that is there was never seen to come: no force until it has been outside.
TEST_F(ServoSessionTest, AReplacedDeviceInheritsNoContact) {
    ASSERT_NO_FATAL_FAILURE(touch_in_real_time());
    time->leap(Clock::now() + std::chrono::milliseconds(21));  // and nobody has called watch
    send({real_state(40, kInside_m, 5)});
    EXPECT_EQ(forces.back().session, 5);
    EXPECT_EQ(forces.back().owner, 5);
    expect_no_force(HAPTABLE_FREE);
    EXPECT_EQ(status("lost_states"), 0);
}

TEST_F(ServoSessionTest, TwoServosHaveTwoNames) {
    ask(0, kAbove_m);
    LocalStepper other_stepper(box.scene());
    Session other(other_stepper, connection, nullptr);
    ask(1, kAbove_m);  // both answer who belongs to none
    ASSERT_EQ(forces.size(), 3U);
    EXPECT_EQ(forces[1].servo, forces[0].servo);
    EXPECT_NE(forces[2].servo, forces[0].servo);
    device_state theirs = state(2, kAbove_m);
    theirs.servo = forces[2].servo;
    send({theirs});
    ASSERT_EQ(forces.size(), 4U);
    EXPECT_EQ(forces[3].servo, forces[2].servo);
    EXPECT_EQ(status("other_servo_states"), 1);
}

// ---- age, number and mode ------------------------------------------------------------------------------------------

// After a stall the finger is where the newest state says; what it did meanwhile is over. In lockstep each is a tick.
TEST_F(ServoSessionTest, OfStatesThatWaitTheNewestIsTaken) {
    send({state(0, kAbove_m), state(1, 0.0305), state(2, kAbove_m)});
    EXPECT_EQ(forces.size(), 3U);
    EXPECT_EQ(status("skipped_states"), 0);
    time->leap(Clock::now() + std::chrono::seconds(2));
    send({real_state(0, kAbove_m, 5)});
    send({real_state(1, 0.0302, 5), real_state(2, 0.0301, 5), real_state(3, 0.0299, 5)});
    ASSERT_EQ(forces.size(), 5U);
    EXPECT_EQ(forces.back().seq, 3);
    EXPECT_EQ(contacts.back().finger_m[2], 0.0299);
    EXPECT_EQ(status("skipped_states"), 2);
    EXPECT_EQ(status("ticks"), 5);
    EXPECT_EQ(status("lost_states"), 0);
}

TEST_F(ServoSessionTest, AStateThatWaited20MsIsNone) {
    send({real_state(0, kAbove_m)});
    time.reset();  // how long a message waits liblcm says by the machine's clock
    connection.publish(channel_of<device_state>(), real_state(1, 0.0305));
    std::this_thread::sleep_for(std::chrono::milliseconds(21));
    handle_all(connection);
    EXPECT_EQ(forces.size(), 1U);
    EXPECT_EQ(status("late_states"), 1);
}

// A clock that stands still says nothing of when the finger was there: silence, however many states come.
TEST_F(ServoSessionTest, TimeThatDoesNotRunIsSilence) {
    ASSERT_NO_FATAL_FAILURE(touch_in_real_time());
    const Clock::time_point heard = session.last_state();
    for (std::int64_t seq = 2; seq < 12; ++seq) {
        device_state frozen = real_state(seq, kInside_m - 1e-4 * double(seq));
        frozen.utime = real_state(1, 0.0).utime;
        send({frozen});
    }
    EXPECT_EQ(forces.size(), 2U);
    EXPECT_EQ(session.last_state(), heard);
    EXPECT_EQ(status("stopped_states"), 10);
    watch_after(60);
    EXPECT_EQ(forces.back().servo_state, HAPTABLE_SILENT);
}

// The same number twice: the same state gets the same answer without a tick, another finger none. Numbers that never
// came are lost.
TEST_F(ServoSessionTest, ANumberIsTakenOnce) {
    touch();
    ask(1, kInside_m);
    ASSERT_EQ(forces.size(), 3U);
    EXPECT_EQ(forces[2].seq, 1);
    EXPECT_EQ(forces[2].force_n[2], forces[1].force_n[2]);
    EXPECT_EQ(status("repeated_states"), 1);
    ask(1, 0.027);
    ask(0, kAbove_m);
    EXPECT_EQ(forces.size(), 3U);
    EXPECT_EQ(status("old_states"), 2);
    for (const std::int64_t seq : {2, 6, 7, 9}) ask(seq, kAbove_m);
    EXPECT_EQ(status("lost_states"), 4);
    EXPECT_EQ(status("ticks"), 6);
}

// A clock of uptime is below 10^12 us: what its time is, is what the message says it is.
TEST_F(ServoSessionTest, TheModeIsTheMessages) {
    device_state early = real_state(0, kAbove_m), nameless = real_state(1, kAbove_m, 0);
    early.utime = 1000;
    send({early, nameless});
    EXPECT_LT(session.watch_at(), Clock::time_point::max()) << "real time is watched";
    for (const std::int8_t mode : {std::int8_t{0}, std::int8_t{3}}) {
        device_state odd = real_state(1, kAbove_m);
        odd.mode = mode;
        send({odd});
    }
    EXPECT_EQ(forces.size(), 1U);
    EXPECT_EQ(status("odd_states"), 3);
}

// A user who looks at the servo's terminal reads who else is there, once, and nothing of a session that goes well.
// States of another model are refused.
TEST_F(ServoSessionTest, TellsWhoElseIsOnTheChannelOnce) {
    for (std::int64_t seq = 0; seq < 20; ++seq) ask(seq, kAbove_m - 1e-4 * double(seq), seq % 2 == 0 ? kHash : 0);
    session.publish_status();
    EXPECT_EQ(told, std::vector<std::string>{});
    ASSERT_EQ(forces.size(), 20U);
    const device_state theirs = state(0, 0.029, 5);
    device_state other_servos = state(0, 0.029, 6);
    other_servos.servo = 77;
    for (std::int64_t seq = 20; seq < 40; ++seq) {
        ask(seq, kAbove_m, kHash + 1);
        send({theirs, other_servos});
        session.publish_status();
    }
    EXPECT_EQ(status("foreign_states"), 20);
    EXPECT_EQ(status("ticks"), 20);
    ASSERT_EQ(told.size(), 3U);
    EXPECT_TRUE(says(told[0], "a device of another scene"));
    EXPECT_TRUE(says(told[1], "a second servo is on the channel"));
    EXPECT_TRUE(says(told[2], "a second device is on the channel"));
}

TEST_F(ServoSessionTest, TellsThatPositionsLookLikeMillimetres) {
    device_state in_mm = state(0, kAbove_m);
    for (double& coordinate : in_mm.position_m) coordinate *= 1000.0;
    send({in_mm});
    session.publish_status();
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "position 13.1 11.2 31 m rejected"));
    EXPECT_TRUE(says(told[0], "looks like millimetres"));
}

}  // namespace
}  // namespace haptable::test
