// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers of one body over memq://: the servo asked by hand, here and behind a line, and with a device of two
// hands.
#include <gtest/gtest.h>

#include <algorithm>

#include "host/run/timeline.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
#include "tests/loop/asked_session.hpp"
#include "tests/loop/recorded_loop.hpp"
#include "tests/moving_body.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;

class TwoFingers : public AskedSession, public testing::TestWithParam<bool> {
protected:
    TwoFingers() : AskedSession(soft_pair().scene(), GetParam()) {}

    void lockstep_both(std::int64_t seq, double depth_m) {
        for (std::size_t finger = 0; finger < kTwo; ++finger) lockstep(finger, seq, depth_m);
    }
    /// The first finger alone, a millisecond deep in each of these ticks, until the second is silent.
    void go_on_alone() {
        for (std::int64_t seq = 20; seq < 45; ++seq) {
            real(0, seq, 0.001);
            wait(milliseconds(1));
        }
    }
    /// Both a millimetre deep, in real time, a tick ago: the next states are 20.
    void press_both() {
        for (std::int64_t seq = 0; seq < 20; ++seq) {
            for (std::size_t finger = 0; finger < kTwo; ++finger)
                real(finger, seq, 1e-4 * static_cast<double>(seq - 9));
            wait(milliseconds(1));
        }
        ASSERT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
        ASSERT_EQ(forces[1].back().servo_state, HAPTABLE_CONTACT);
    }
};
INSTANTIATE_TEST_SUITE_P(Behind, TwoFingers, testing::Bool(), name_of_place);

TEST_P(TwoFingers, OneDeviceFeelsWhatASceneOfOneGives) {
    Finger alone(*soft_pair().scene_of_one().model);
    for (std::int64_t seq = 0; seq < 50; ++seq) {
        const double depth_m = 1e-4 * static_cast<double>(seq - 10);
        lockstep(0, seq, depth_m);
        ASSERT_EQ(forces[0].size(), static_cast<std::size_t>(seq) + 1);
        alone.to(place(0, depth_m));
        ASSERT_EQ(Vector3d(forces[0].back().force_n), alone.force()) << seq;
    }
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_TRUE(forces[1].empty());
    EXPECT_EQ(status("ticks_2"), 0);
}

// In lockstep a tick is both states, and its forces are those of the pair, each on its own channel.
TEST_P(TwoFingers, ATickIsBothAndItsForcesAreThePairs) {
    lockstep_both(0, -0.001);
    SceneState pair = state_of(soft_pair().scene());
    haptable_output out[2];
    for (std::int64_t seq = 1; seq < 60; ++seq) {
        const double depth_m = 1e-4 * static_cast<double>(seq - 10);
        lockstep(seq % 2 == 0 ? 0 : 1, seq, depth_m);
        ASSERT_EQ(forces[0].size() + forces[1].size(), static_cast<std::size_t>(2 * seq)) << "one waits";
        lockstep(seq % 2 == 0 ? 1 : 0, seq, depth_m);
        haptable_input in[2]{};
        for (std::size_t f = 0; f < 2; ++f) {
            in[f].is_there = 1;
            std::copy_n(place(f, depth_m).data(), 3, in[f].finger_m);
        }
        pair.step(in, static_cast<std::uint32_t>(seq * 1000), out);
        for (std::size_t f = 0; f < 2; ++f) {
            ASSERT_EQ(forces[f].size(), static_cast<std::size_t>(seq) + 1);
            EXPECT_EQ(forces[f].back().seq, seq);
            EXPECT_EQ(forces[f].back().utime, seq * 1000);
            EXPECT_EQ(forces[f].back().servo, forces[0].front().servo);
            ASSERT_EQ(Vector3d(forces[f].back().force_n), to_vector(out[f].force_n)) << seq;
        }
    }
    EXPECT_EQ(out[0].state, HAPTABLE_CONTACT);
    EXPECT_EQ(contacts[1].back().count, 3);
    EXPECT_EQ(contacts[1].back().finger_m[0], place(1, 0.0)[0]);
    EXPECT_EQ(status("contact_ticks"), status("contact_ticks_2"));
    EXPECT_GT(status("energy_most_stored_nj_2"), 1000);
    expect_the_hosts_record();
}

TEST_P(TwoFingers, WhoComesLaterIsTakenInWhoeverAsksFirst) {
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
        for (std::size_t finger = 0; finger < kTwo; ++finger) {
            ASSERT_EQ(forces[finger].back().seq, seq);
            EXPECT_EQ(forces[finger].back().utime, forces[0].back().utime);
            EXPECT_EQ(contacts[finger].back().seq, seq);
        }
    }
    EXPECT_GT(forces[1].back().force_n[2], 0.0);
    EXPECT_EQ(status("ticks_2"), 56);
    EXPECT_EQ(status("contact_ticks"), status("contact_ticks_2"));
    expect_the_hosts_record();
}

// ---- one is late, or silent ---------------------------------------------------------------------------------------

TEST_P(TwoFingers, AStateWaitsAMillisecondForTheOthersAndNotAgain) {
    press_both();
    const std::size_t before = forces[0].size();
    real(0, 20, 0.0011);
    EXPECT_EQ(forces[0].size(), before) << "it waits";
    EXPECT_EQ(session->watch_at(), time->now() + kTick);
    wait(milliseconds(1));
    ASSERT_EQ(forces[0].size(), before + 1);
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_EQ(forces[1].size(), before) << "who did not ask has no answer";
    if (behind) {
        EXPECT_EQ(behind->target.output(1).state, HAPTABLE_CONTACT) << "it is where it was";
    }
    real(0, 21, 0.0011);
    EXPECT_EQ(forces[0].size(), before + 2) << "nobody waits again for who was late";
    real(1, 22, 0.001);
    EXPECT_EQ(forces[1].size(), before) << "who comes again is waited for, and waits";
    real(0, 22, 0.0011);
    EXPECT_EQ(forces[1].size(), before + 1);
    EXPECT_EQ(forces[0].back().utime, forces[1].back().utime);
    EXPECT_EQ(status("lost_states_2"), 2);
}

TEST_P(TwoFingers, ASilentFingerIsReleasedAndTheOtherGoesOn) {
    press_both();
    const double both_n = forces[0].back().force_n[2];
    const std::size_t answers = forces[1].size();
    go_on_alone();
    ASSERT_EQ(forces[1].size(), answers + 1) << "told once";
    expect_no_force(HAPTABLE_SILENT, 1);
    EXPECT_EQ(forces[1].back().seq, 19);
    EXPECT_EQ(contacts[1].back().count, 0);
    EXPECT_EQ(forces[0].back().seq, 44);
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_GT(forces[0].back().force_n[2], 1.02 * both_n) << "nothing takes the surface away any more";
    if (behind) {
        EXPECT_EQ(behind->target.output(1).state, HAPTABLE_SILENT);
    } else {
        EXPECT_EQ(status("silences"), 0);
        EXPECT_EQ(status("silences_2"), 1);
    }
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "finger 2: contact dropped after a silence of 20 ms"));
}

// It begins anew: inside, where nobody saw it come, it feels nothing; the first goes on in its contact.
TEST_P(TwoFingers, ADeviceThatRestartsInheritsNoContact) {
    press_both();
    go_on_alone();
    device_state again = state(1, 0, 0.001, device_state::REAL_TIME);
    again.session = 77;
    send(1, again);
    EXPECT_EQ(forces[1].back().session, 77);
    EXPECT_EQ(forces[1].back().servo_state, HAPTABLE_FREE);
    EXPECT_EQ(forces[1].back().force_n[2], 0.0);
    real(0, 45, 0.001);
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
}

// In lockstep time stands still: only a device that is gone for a second of real time is not waited for.
TEST_P(TwoFingers, InLockstepADeviceThatIsGoneIsReleased) {
    lockstep_both(0, -0.001);
    for (std::int64_t seq = 1; seq < 30; ++seq) lockstep_both(seq, 1e-4 * static_cast<double>(seq - 9));
    lockstep(0, 30, 0.002);
    wait(milliseconds(900));
    EXPECT_EQ(forces[0].back().seq, 29);
    wait(milliseconds(200));
    EXPECT_EQ(forces[0].back().seq, 30);
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_EQ(forces[1].back().servo_state, HAPTABLE_SILENT);
    lockstep(0, 31, 0.002);
    EXPECT_EQ(forces[0].back().seq, 31);
}

// ---- who does not belong here -------------------------------------------------------------------------------------

TEST_P(TwoFingers, ASecondDeviceOfOneFingerIsRefusedAndToldOnce) {
    press_both();
    const std::size_t answers = forces[1].size(), loads = contacts[1].size();
    for (std::int64_t seq = 20; seq < 25; ++seq) {
        device_state theirs = state(1, seq, 0.001, device_state::REAL_TIME);
        theirs.session = 5;
        send(1, theirs);
        session->publish_status();
    }
    ASSERT_EQ(forces[1].size(), answers + 5);
    EXPECT_EQ(forces[1].back().session, 5);
    EXPECT_EQ(forces[1].back().owner, kSession + 1);
    expect_no_force(HAPTABLE_SILENT, 1);
    EXPECT_EQ(status("other_device_states_2"), 5);
    EXPECT_EQ(status("other_device_states"), 0);
    EXPECT_EQ(status("session_2"), kSession + 1);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "finger 2: a second device"));
    for (std::size_t finger = 0; finger < kTwo; ++finger) real(finger, 20, 0.001);
    EXPECT_EQ(forces[1].back().session, kSession + 1);
    EXPECT_EQ(forces[1].back().servo_state, HAPTABLE_CONTACT) << "its contact is as it was";
    EXPECT_EQ(contacts[1].size(), loads + 1);
}

TEST_P(TwoFingers, LockstepAndRealTimeHaveNoTickInCommon) {
    press_both();
    const std::size_t answers = forces[1].size();
    wait(milliseconds(25));
    real(0, 60, 0.001);
    lockstep(1, 60, 0.001);
    EXPECT_EQ(forces[1].size(), answers + 1) << "the last word alone";
    EXPECT_EQ(status("odd_states_2"), 1);
}

TEST_P(TwoFingers, InRealTimeAForceThatIsLostIsOvertaken) {
    if (!behind) return;  // here none is lost
    press_both();
    FakeTarget<Pipes>& target = behind->target;
    const std::uint32_t ticks = target.counters(0).ticks;
    const std::size_t answers = forces[0].size();
    answers_by_itself = false;
    for (std::size_t finger = 0; finger < kTwo; ++finger) real(finger, 20, 0.0011);
    EXPECT_EQ(target.answer(true), 1);  // and it is lost on its way
    exchange();
    EXPECT_EQ(forces[0].back().seq, 19);
    for (std::size_t finger = 0; finger < kTwo; ++finger) real(finger, 21, 0.0011);
    session->watch(Clock::now() + milliseconds(10));  // longer than the answer is waited for
    EXPECT_EQ(target.answer(), 1);
    exchange();
    EXPECT_EQ(forces[0].size(), answers + 1);
    EXPECT_EQ(forces[1].back().seq, 21);
    EXPECT_EQ(target.counters(0).ticks, ticks + 2);
    EXPECT_EQ(status("lost_answers"), 1);
    EXPECT_EQ(status("lost_answers_2"), 1);
}

// ---- two hands, their log and their record ------------------------------------------------------------------------

class TwoHands : public RecordedLoop {
protected:
    /// A pinch by two hands of one device.
    std::vector<DeviceReport> pinch(const std::string& tag, bool lockstep = true, const std::string& faults = "") {
        const auto from = [](double x, double way) {
            PathOptions at;
            at.at_m = {x, 0.0143, 0.02};
            at.direction = {way, 0.0, 0.0};
            return scripted_path("poke", at);
        };
        SessionOptions options;
        options.lockstep = lockstep;
        options.seconds = 1.0;
        if (!faults.empty()) options.faults = parse_faults(faults);
        return run(scene, tag, {from(0.0, 1.0), from(0.03, -1.0)}, options);
    }
    void expect_both_again(const std::string& tag) const {
        const ReplayReport report = expect_same_again(tag, scene);
        EXPECT_GT(report.compared, 1000);
        ASSERT_EQ(report.others.size(), 1U);
        EXPECT_GT(std::int64_t{report.others[0].counters.contact_ticks}, 10);
    }

    ServoScene scene = soft_pair().scene();
};

TEST_F(TwoHands, TheTableOfASessionHasBoth) {
    pinch("a");
    const Timeline timeline = read_timeline(log("a"));
    ASSERT_EQ(timeline.ticks.size(), 1000U);
    ASSERT_EQ(timeline.others.at(0).size(), 1000U);
    double largest_n = 0.0, stored_j = 0.0;
    for (const Tick& tick : timeline.others[0]) {
        EXPECT_TRUE(tick.answered);
        largest_n = std::fmax(largest_n, tick.force_size_n());
        stored_j = std::fmax(stored_j, tick.stored_j);
    }
    const ReplayReport report = replay(scene, log("a"), "", true);
    EXPECT_EQ(largest_n, report.others[0].largest_force_n);
    EXPECT_WITHIN(std::abs(stored_j - report.others[0].energy.most_stored_j()), .count = 16, .epsilon = kFloat,
                  .condition = 0.03 / 0.004, .size = stored_j);
    write_csv(timeline, folder / "session.csv");
    const auto rows = lines_of(read_file(folder / "session.csv"));
    ASSERT_EQ(rows.size(), 2001U);
    EXPECT_TRUE(rows[0].ends_with(",energy_given_j,finger"));
    EXPECT_EQ(std::count_if(rows.begin(), rows.end(), [](const std::string& row) { return row.ends_with(",2"); }),
              1000);
    EXPECT_FALSE(is_fault("ticks_2"));
    EXPECT_TRUE(is_fault("lost_states_2"));
}

TEST_F(TwoHands, LockstepGivesTheSameBytesTwiceWhateverIsLostAndFromItsRecords) {
    for (const DeviceReport& report : pinch("whole")) {
        EXPECT_EQ(report.missed, 0);
        EXPECT_EQ(report.resent, 0);
        EXPECT_GT(report.contact_ticks, 100);
        EXPECT_GT(report.largest_force_n, 0.1);
    }
    expect_both_again("whole");
    const auto reports = pinch("lossy", true, "drop=0.03,double=0.05");
    EXPECT_GT(reports[0].resent + reports[1].resent, 5);
    EXPECT_EQ(first_other(csv("whole"), csv("lossy")), "");
    EXPECT_EQ(first_other(device_csv("whole"), device_csv("lossy")), "");
    expect_both_again("lossy");
}

// With faults: silences of either, lost and late states, positions that are none.
TEST_F(TwoHands, RealTimeGivesTheSameForcesFromItsLog) {
    for (const DeviceReport& report : pinch("a", false))
        EXPECT_LT(report.latency.max_us(), 1.0);  // of simulated time: neither waits for the other
    expect_both_again("a");
    for (const DeviceReport& report : pinch("b", false, "drop=0.02,reorder=0.02,gone=0.003:40ms,nan=0.002"))
        EXPECT_GT(report.silences, 0);
    expect_both_again("b");
}

TEST_F(TwoHands, ABodyThatNothingHoldsMovesOnceATick) {
    haptable_body body = cube_body();
    add_gravity(body);
    add_floor(body, 0.0, 0.5);
    scene.body = &body;
    pinch("a");
    expect_both_again("a");
    const auto rows = read_rows(csv("a"));
    EXPECT_EQ(rows[0].size(), 1U + 19U + 19U + 7U);
    // A force on each side, and the cube between them.
    double most_n[2] = {0.0, 0.0};
    for (const auto& row : rows) {
        most_n[0] = std::max(most_n[0], -row.at("force_x"));
        most_n[1] = std::max(most_n[1], row.at("force_x2"));
    }
    EXPECT_GT(most_n[0], 0.05);
    EXPECT_GT(most_n[1], 0.05);
    // The cube has moved; what is stored is of its own frame, for the servo as for who reads the log.
    double stored_j = 0.0, deepest_m = 0.0;
    for (const Tick& tick : read_timeline(log("a")).ticks) {
        stored_j = std::fmax(stored_j, tick.stored_j);
        deepest_m = std::fmax(deepest_m, tick.depth_m);
    }
    const ReplayReport report = replay(scene, log("a"), "", true);
    EXPECT_LT(deepest_m, 0.006);
    EXPECT_WITHIN(std::abs(stored_j - report.energy.most_stored_j()), .count = 64, .epsilon = kFloat,
                  .condition = 0.03 / 0.004, .size = stored_j);
}

}  // namespace
}  // namespace haptable::test
