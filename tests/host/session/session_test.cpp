// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's side of the loop over memq://, asked by hand.
#include "host/session/session.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <thread>

#include "host/session/local_stepper.hpp"
#include "tests/finger.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

constexpr std::int64_t kHash = 1;  // of the test's model

class ServoSessionTest : public testing::Test {
protected:
    ServoSessionTest()
        : session(stepper, connection, nullptr, [this](const std::string& line) { told.push_back(line); }) {
        connection.subscribe<servo_force>(channel_of<servo_force>(),
                                          [this](const servo_force& m, std::int64_t) { forces.push_back(m); });
        connection.subscribe<contact>(channel_of<contact>(),
                                      [this](const contact& m, std::int64_t) { contacts.push_back(m); });
        connection.subscribe<servo_status>(channel_of<servo_status>(),
                                           [this](const servo_status& m, std::int64_t) { statuses.push_back(m); });
    }

    /// One state in simulated time, and what comes of it.
    void ask(std::int64_t seq, double z, std::int64_t model_hash = 0) {
        device_state asked = state(seq, z);
        asked.model_hash = model_hash;
        send({asked});
    }
    /// A device's next state, a millisecond after the last.
    static device_state state(std::int64_t seq, double z) {
        device_state state = simulated_state(seq, seq * 1000);
        state.position_m[0] = 0.0131;
        state.position_m[1] = 0.0112;
        state.position_m[2] = z;
        return state;
    }
    /// The same in real time, by the clock of a device of its own.
    static device_state real_state(std::int64_t seq, double z, std::int64_t session = kSession) {
        device_state real = state(seq, z);
        real.mode = device_state::REAL_TIME;
        real.utime += 1'800'000'000'000'000;
        real.session = session;
        return real;
    }
    /// States that come at once.
    void send(const std::vector<device_state>& states) {
        for (const device_state& one : states) connection.publish(channel_of<device_state>(), one);
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

TEST_F(ServoSessionTest, AnswersEachStateAsTheFirmwareDoes) {
    haptable_servo servo;
    haptable_servo_init(&servo);
    for (std::int64_t seq = 0; seq < 50; ++seq) {
        const double z = 0.0305 - 1e-4 * static_cast<double>(seq);
        ask(seq, z);
        const double position_m[3] = {0.0131, 0.0112, z};
        haptable_output out;
        haptable_servo_step(box.scene().model, &servo, to_finger(position_m).data(),
                            static_cast<std::uint32_t>(seq * 1000), &out);
        ASSERT_EQ(forces.size(), static_cast<std::size_t>(seq) + 1);
        EXPECT_EQ(forces.back().seq, seq);
        EXPECT_EQ(forces.back().utime, seq * 1000);
        EXPECT_EQ(forces.back().model_hash, kHash);
        EXPECT_EQ(forces.back().servo_state, out.state);
        for (int a = 0; a < 3; ++a) EXPECT_EQ(forces.back().force_n[a], static_cast<double>(out.force_n[a]));
    }
    EXPECT_EQ(forces.back().servo_state, HAPTABLE_CONTACT);
}

// Pressed and lifted on the same way, what is stored comes back, but for what a sampled spring gives in its ticks.
TEST_F(ServoSessionTest, StatusTellsTheEnergies) {
    std::int64_t seq = 0;
    for (; seq <= 100; ++seq) ask(seq, 0.0301 - 4e-5 * static_cast<double>(seq));
    const auto nanojoules = [this](const char* name) { return static_cast<double>(status(name)); };
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
    for (; seq <= 202; ++seq) ask(seq, 0.0301 - 4e-5 * static_cast<double>(200 - seq));
    EXPECT_EQ(nanojoules("energy_stored_nj"), 0.0);
    EXPECT_EQ(nanojoules("energy_most_stored_nj"), stored_nj);
    EXPECT_WITHIN(std::abs(nanojoules("energy_given_nj") - 2.0 * stored_nj / 100.0), .epsilon = 0.02,
                  .size = stored_nj);
    EXPECT_LE(std::abs(stepper.report().energy.most_stored_j() * 1e9 - stored_nj), 0.5) << "rounded to a whole nJ";
}

// The forces on the nodes are the finger's action, the user's force is their reaction (eq. 12).
TEST_F(ServoSessionTest, ContactMessageCarriesTheLoad) {
    ask(0, 0.031);
    EXPECT_EQ(contacts.back().count, 0);
    ask(1, 0.028);
    const contact& touched = contacts.back();
    ASSERT_EQ(touched.count, 3);
    EXPECT_EQ(touched.seq, 1);
    EXPECT_EQ(touched.model_hash, kHash);
    EXPECT_EQ(touched.finger_m[2], 0.028);
    EXPECT_WITHIN(std::abs(touched.god_object_m[2] - 0.03), rounded(box.model()));
    for (std::size_t a = 0; a < 3; ++a) {
        double sum = 0.0;
        for (const auto& force_n : touched.force_n) sum += force_n[a];
        EXPECT_WITHIN(std::abs(sum + forces.back().force_n[a]), .count = 16, .epsilon = kFloat);
    }
    for (const std::int32_t node : touched.node)  // mesh nodes of the top
        EXPECT_GT(box.model().tables().position[static_cast<std::size_t>(node)][2], 0.0299);
}

TEST_F(ServoSessionTest, RefusesStatesOfAnotherModel) {
    ask(0, 0.031, kHash + 1);
    EXPECT_TRUE(forces.empty());
    ask(0, 0.031, kHash);
    ask(1, 0.031, 0);
    EXPECT_EQ(forces.size(), 2U);
    EXPECT_EQ(status("foreign_states"), 1);
    EXPECT_EQ(status("ticks"), 2);
}

TEST_F(ServoSessionTest, AnswersARepeatedStateWithoutASecondTick) {
    ask(0, 0.031);
    ask(1, 0.028);
    ask(1, 0.028);
    ASSERT_EQ(forces.size(), 3U);
    EXPECT_EQ(forces[2].seq, 1);
    EXPECT_EQ(forces[2].force_n[2], forces[1].force_n[2]);
    EXPECT_EQ(status("ticks"), 2);
    EXPECT_EQ(status("repeated_states"), 1);
}

TEST_F(ServoSessionTest, CountsLostStates) {
    for (const std::int64_t seq : {0, 1, 2, 6, 7, 9}) ask(seq, 0.031);
    EXPECT_EQ(status("lost_states"), 4);
    EXPECT_EQ(status("ticks"), 6);
}

TEST_F(ServoSessionTest, StatusNamesEveryCounterOfTheFirmware) {
    ask(0, 0.031);
    time.reset();  // a step takes some
    ask(1, 0.028);
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
    ask(0, 0.031);
    ask(1, 0.028);
    ask(2, std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(forces.back().servo_state, HAPTABLE_REJECTED);
    EXPECT_EQ(forces.back().force_n[2], 0.0);
    EXPECT_EQ(contacts.back().count, 0);
    EXPECT_EQ(status("rejected_positions"), 1);
}

// In real time: zero force, said once, and not before the 20 ms are over.
TEST_F(ServoSessionTest, FallsSilentWithoutStates) {
    send({real_state(0, 0.031)});
    send({real_state(1, 0.028)});
    ASSERT_EQ(forces.back().servo_state, HAPTABLE_CONTACT);
    const Clock::time_point asked = session.last_state();
    EXPECT_EQ(session.watch_at() - asked, std::chrono::milliseconds(20));
    session.watch(asked + std::chrono::milliseconds(19));
    handle_all(connection);
    EXPECT_EQ(forces.size(), 2U);
    // The firmware's clock began with the step, a little after the state came.
    for (int ms = 60'000; ms < 60'003; ++ms) session.watch(asked + std::chrono::milliseconds(ms));
    handle_all(connection);
    ASSERT_EQ(forces.size(), 3U);
    EXPECT_EQ(forces[2].servo_state, HAPTABLE_SILENT);
    EXPECT_EQ(forces[2].seq, 1);
    for (const double component : forces[2].force_n) EXPECT_EQ(component, 0.0);
    EXPECT_EQ(contacts.back().count, 0);
    EXPECT_EQ(session.watch_at(), Clock::time_point::max());
    EXPECT_EQ(status("silences"), 1);
}

TEST_F(ServoSessionTest, SimulatedTimeStandsStillBetweenStates) {
    ask(0, 0.031);
    ask(1, 0.028);
    session.watch(Clock::now() + std::chrono::hours(1));
    handle_all(connection);
    EXPECT_EQ(forces.size(), 2U);
    EXPECT_EQ(status("silences"), 0);
}

// ---- whose servo it is ---------------------------------------------------------------------------------------------

TEST_F(ServoSessionTest, ASecondDeviceGetsNoForceAndIsTold) {
    send({state(0, 0.031), state(1, 0.028)});
    const std::size_t before = contacts.size();
    device_state theirs = state(0, 0.029);
    theirs.session = 5;
    send({theirs, state(2, 0.027)});
    ASSERT_EQ(forces.size(), 4U);
    EXPECT_EQ(forces[2].session, 5);
    EXPECT_EQ(forces[2].owner, kSession);
    EXPECT_EQ(forces[2].servo_state, HAPTABLE_SILENT);
    for (const double component : forces[2].force_n) EXPECT_EQ(component, 0.0);
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
    send({real_state(0, 0.031)});
    send({real_state(1, 0.028)});
    ASSERT_EQ(forces.back().servo_state, HAPTABLE_CONTACT);
    time->leap(Clock::now() + std::chrono::milliseconds(21));  // and nobody has called watch
    send({real_state(40, 0.028, 5)});
    EXPECT_EQ(forces.back().session, 5);
    EXPECT_EQ(forces.back().owner, 5);
    EXPECT_EQ(forces.back().servo_state, HAPTABLE_FREE);
    EXPECT_EQ(forces.back().force_n[2], 0.0);
    EXPECT_EQ(status("lost_states"), 0);
}

TEST_F(ServoSessionTest, TwoServosHaveTwoNames) {
    ask(0, 0.031);
    LocalStepper other_stepper(box.scene());
    Session other(other_stepper, connection, nullptr);
    ask(1, 0.031);  // both answer who belongs to none
    ASSERT_EQ(forces.size(), 3U);
    EXPECT_EQ(forces[1].servo, forces[0].servo);
    EXPECT_NE(forces[2].servo, forces[0].servo);
    device_state theirs = state(2, 0.031);
    theirs.servo = forces[2].servo;
    send({theirs});
    ASSERT_EQ(forces.size(), 4U);
    EXPECT_EQ(forces[3].servo, forces[2].servo);
    EXPECT_EQ(status("other_servo_states"), 1);
}

// ---- age -----------------------------------------------------------------------------------------------------------

// After a stall the finger is where the newest state says; what it did meanwhile is over.
TEST_F(ServoSessionTest, OfStatesThatWaitTheNewestIsTaken) {
    send({real_state(0, 0.031)});
    send({real_state(1, 0.0302), real_state(2, 0.0301), real_state(3, 0.0299)});
    ASSERT_EQ(forces.size(), 2U);
    EXPECT_EQ(forces.back().seq, 3);
    EXPECT_EQ(contacts.back().finger_m[2], 0.0299);
    EXPECT_EQ(status("skipped_states"), 2);
    EXPECT_EQ(status("ticks"), 2);
    EXPECT_EQ(status("lost_states"), 0);
}

TEST_F(ServoSessionTest, InLockstepEveryStateIsATick) {
    send({state(0, 0.031), state(1, 0.0305), state(2, 0.0295)});
    EXPECT_EQ(forces.size(), 3U);
    EXPECT_EQ(status("skipped_states"), 0);
}

TEST_F(ServoSessionTest, AStateThatWaited20MsIsNone) {
    send({real_state(0, 0.031)});
    time.reset();  // how long a message waits liblcm says by the machine's clock
    connection.publish(channel_of<device_state>(), real_state(1, 0.0305));
    std::this_thread::sleep_for(std::chrono::milliseconds(21));
    handle_all(connection);
    EXPECT_EQ(forces.size(), 1U);
    EXPECT_EQ(status("late_states"), 1);
}

// A clock that stands still says nothing of when the finger was there: silence, however many states come.
TEST_F(ServoSessionTest, TimeThatDoesNotRunIsSilence) {
    send({real_state(0, 0.031)});
    send({real_state(1, 0.028)});
    const Clock::time_point heard = session.last_state();
    for (std::int64_t seq = 2; seq < 12; ++seq) {
        device_state frozen = real_state(seq, 0.028 - 1e-4 * static_cast<double>(seq));
        frozen.utime = real_state(1, 0.0).utime;
        send({frozen});
    }
    EXPECT_EQ(forces.size(), 2U);
    EXPECT_EQ(session.last_state(), heard);
    EXPECT_EQ(status("stopped_states"), 10);
    session.watch(heard + std::chrono::milliseconds(60));
    handle_all(connection);
    EXPECT_EQ(forces.back().servo_state, HAPTABLE_SILENT);
}

// The same number twice: the same state gets the same answer, another finger none.
TEST_F(ServoSessionTest, ANumberIsTakenOnce) {
    ask(0, 0.031);
    ask(1, 0.028);
    ask(1, 0.027);
    ask(0, 0.031);
    EXPECT_EQ(forces.size(), 2U);
    EXPECT_EQ(status("old_states"), 2);
    EXPECT_EQ(status("repeated_states"), 0);
}

// A clock of uptime is below 10^12 us: what its time is, is what the message says it is.
TEST_F(ServoSessionTest, TheModeIsTheMessages) {
    device_state early = real_state(0, 0.031);
    early.utime = 1000;
    send({early});
    EXPECT_LT(session.watch_at(), Clock::time_point::max()) << "real time is watched";
    for (const std::int8_t mode : {std::int8_t{0}, std::int8_t{3}}) {
        device_state odd = real_state(1, 0.031);
        odd.mode = mode;
        send({odd});
    }
    device_state nameless = real_state(1, 0.031);
    nameless.session = 0;
    send({nameless});
    EXPECT_EQ(forces.size(), 1U);
    EXPECT_EQ(status("odd_states"), 3);
}

TEST_F(ServoSessionTest, TheLargestNumberIsANumber) {
    ask(0, 0.031);
    device_state last = state(std::numeric_limits<std::int64_t>::max(), 0.031);
    last.utime = 1000;
    send({last});
    EXPECT_EQ(forces.size(), 2U);
    EXPECT_EQ(status("lost_states"), std::numeric_limits<std::int64_t>::max() - 1);
}

// A user who looks at the servo's terminal reads who else is there, once, and nothing of a session that goes well.
TEST_F(ServoSessionTest, TellsWhoElseIsOnTheChannelOnce) {
    for (std::int64_t seq = 0; seq < 20; ++seq) ask(seq, 0.031 - 1e-4 * static_cast<double>(seq));
    session.publish_status();
    EXPECT_EQ(told, std::vector<std::string>{});
    device_state theirs = state(0, 0.029), other_servos = state(0, 0.029);
    theirs.session = 5;
    other_servos.session = 6;
    other_servos.servo = 77;
    for (std::int64_t seq = 20; seq < 40; ++seq) {
        ask(seq, 0.031, kHash + 1);
        send({theirs, other_servos});
        session.publish_status();
    }
    ASSERT_EQ(told.size(), 3U);
    EXPECT_NE(told[0].find("a device of another scene"), std::string::npos) << told[0];
    EXPECT_NE(told[1].find("a second servo is on the channel"), std::string::npos) << told[1];
    EXPECT_NE(told[2].find("a second device is on the channel"), std::string::npos) << told[2];
}

TEST_F(ServoSessionTest, TellsThatPositionsLookLikeMillimetres) {
    device_state in_mm = state(0, 31.0);
    in_mm.position_m[0] *= 1000.0;
    in_mm.position_m[1] *= 1000.0;
    send({in_mm});
    session.publish_status();
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("position 13.1 11.2 31 m rejected"), std::string::npos) << told[0];
    EXPECT_NE(told[0].find("looks like millimetres"), std::string::npos) << told[0];
}

TEST_F(ServoSessionTest, TellsThatSilenceDroppedTheContact) {
    send({real_state(0, 0.031)});
    session.watch(session.last_state() + std::chrono::milliseconds(30));
    EXPECT_EQ(told, std::vector<std::string>{}) << "there was none";
    send({real_state(100, 0.031), real_state(101, 0.031)});
    send({real_state(102, 0.028)});
    ASSERT_EQ(forces.back().servo_state, HAPTABLE_CONTACT);
    for (const int ms : {30, 40}) session.watch(session.last_state() + std::chrono::milliseconds(ms));
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("contact dropped after a silence of 30 ms"), std::string::npos) << told[0];
}

}  // namespace
}  // namespace haptable::test
