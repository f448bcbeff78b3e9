// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers of one body over memq://: the servo asked by hand, here and behind a line, and with a device of two
// hands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>

#include "host/device/session.hpp"
#include "host/device/simulated_driver.hpp"
#include "host/link/log_writer.hpp"
#include "host/run/recorder.hpp"
#include "host/run/timeline.hpp"
#include "host/session/bridge/line_stepper.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/finger.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/loop/soft_pair.hpp"
#include "tests/moving_body.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;
using std::chrono::milliseconds;

constexpr std::size_t kTwo = 2;

const SoftPair& soft_pair() {
    static const SoftPair pair;
    return pair;
}

/// Two sides of the top, and how deep.
Vector3d place(std::size_t finger, double depth_m) { return {finger == 0 ? 0.0102 : 0.0197, 0.0143, 0.03 - depth_m}; }

/// A servo at the other end of a line.
struct Behind {
    explicit Behind(const ServoScene& scene) : line(pipes.line(), scene), target(scene, pipes) {}
    Pipes pipes;
    SerialTarget line;
    FakeTarget<Pipes> target;
};

/// A session whose ticks are computed in this process, or behind a line. Real time stands still but where a test lets
/// it go on.
class SessionOfTwo : public testing::Test {
protected:
    SessionOfTwo(bool is_behind_a_line, const ServoScene& of) : scene(of) {
        if (is_behind_a_line) behind.emplace(scene);
        if (behind) stepper = std::make_unique<LineStepper>(behind->line, LineOptions{});
        if (!behind) stepper = std::make_unique<LocalStepper>(scene);
        session.emplace(*stepper, connection, &*record, [this](const std::string& line) { told.push_back(line); });
        time.also([this] { return session->watch_at(); },
                  [this](Clock::time_point now) {
                      session->watch(now);
                      exchange();
                  });
        for (std::size_t finger = 0; finger < kTwo; ++finger) {
            connection.subscribe<servo_force>(
                channel_of<servo_force>(finger),
                [this, finger](const servo_force& m, std::int64_t) { forces[finger].push_back(m); });
            connection.subscribe<contact>(channel_of<contact>(finger), [this, finger](const contact& m, std::int64_t) {
                contacts[finger].push_back(m);
            });
        }
        connection.subscribe<servo_status>(channel_of<servo_status>(),
                                           [this](const servo_status& m, std::int64_t) { status_ = m; });
        session->take_answers();  // a target's hello
    }

    static device_state state(std::size_t finger, std::int64_t seq, double depth_m, std::int8_t mode) {
        device_state state = simulated_state(seq, seq * 1000);
        state.session += static_cast<std::int64_t>(finger);
        state.mode = mode;
        std::copy_n(place(finger, depth_m).data(), 3, state.position_m);
        return state;
    }
    void exchange() {
        if (behind && answers_by_itself) behind->target.answer();
        session->take_answers();
        handle_all(connection);
    }
    void send(std::size_t finger, const device_state& state) {
        connection.publish(channel_of<device_state>(finger), state);
        handle_all(connection);
        exchange();
    }
    void lockstep(std::size_t finger, std::int64_t seq, double depth_m) {
        send(finger, state(finger, seq, depth_m, device_state::SIMULATED));
    }
    void real(std::size_t finger, std::int64_t seq, double depth_m) {
        send(finger, state(finger, seq, depth_m, device_state::REAL_TIME));
    }
    /// A session that always has something due is an error, not a test for ever.
    void wait(milliseconds ms) {
        const Clock::time_point until = time.now() + ms;
        for (int leaps = 0; time.now() < until; ++leaps) {
            if (leaps > 10 + 10 * ms.count()) throw std::runtime_error("the session's work is never done");
            time.leap(until);
        }
        exchange();
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
    std::int64_t status(const std::string& name) {
        session->publish_status();
        handle_all(connection);
        const auto found = std::find(status_.name.begin(), status_.name.end(), name);
        if (found != status_.name.end()) return status_.value[static_cast<std::size_t>(found - status_.name.begin())];
        ADD_FAILURE() << "no counter is called " << name;
        return -1;
    }
    /// The host's servo writes the same bytes of the same path.
    void expect_the_hosts_record() {
        record->finish();
        replay(scene, folder / "record.csv", folder / "host.csv", true);
        EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "record.csv"));
    }

    const ServoScene scene;
    WorkFolder folder;
    SimulatedTime time;
    Connection connection{"memq://"};
    std::optional<Behind> behind;
    bool answers_by_itself = true;
    std::optional<ServoRecord> record{std::in_place, scene, folder / "record.csv"};
    std::vector<std::string> told;
    std::unique_ptr<Stepper> stepper;
    std::optional<Session> session;
    std::array<std::vector<servo_force>, kTwo> forces;
    std::array<std::vector<contact>, kTwo> contacts;
    servo_status status_;
};

constexpr auto name_of_place = [](const testing::TestParamInfo<bool>& of) { return of.param ? "Line" : "Process"; };

class TwoFingers : public SessionOfTwo, public testing::WithParamInterface<bool> {
protected:
    TwoFingers() : SessionOfTwo(GetParam(), soft_pair().scene()) {}
};
INSTANTIATE_TEST_SUITE_P(Behind, TwoFingers, testing::Bool(), name_of_place);

TEST_P(TwoFingers, OneDeviceFeelsWhatASceneOfOneGives) {
    const ServoScene one = soft_pair().scene_of_one();
    haptable_servo servo;
    haptable_servo_init(&servo);
    check_tables(*one.model, servo);
    for (std::int64_t seq = 0; seq < 50; ++seq) {
        const double depth_m = 1e-4 * static_cast<double>(seq - 10);
        lockstep(0, seq, depth_m);
        haptable_output out;
        haptable_servo_step(one.model, &servo, to_finger(place(0, depth_m).data()).data(),
                            static_cast<std::uint32_t>(seq * 1000), &out);
        ASSERT_EQ(forces[0].size(), static_cast<std::size_t>(seq) + 1);
        for (int a = 0; a < 3; ++a) ASSERT_EQ(forces[0].back().force_n[a], double{out.force_n[a]});
    }
    EXPECT_EQ(forces[0].back().servo_state, HAPTABLE_CONTACT);
    EXPECT_TRUE(forces[1].empty());
    EXPECT_EQ(status("ticks_2"), 0);
}

// In lockstep a tick is both states, and its forces are those of the pair, each on its own channel.
TEST_P(TwoFingers, ATickIsBothAndItsForcesAreThePairs) {
    lockstep(0, 0, -0.001);
    lockstep(1, 0, -0.001);
    haptable_room room{};
    haptable_pair& pair = room.fingers;
    haptable_pair_init(soft_pair().scene().pair, &pair);
    haptable_output out[2];
    for (std::int64_t seq = 1; seq < 60; ++seq) {
        const double depth_m = 1e-4 * static_cast<double>(seq - 10);
        lockstep(seq % 2 == 0 ? 0 : 1, seq, depth_m);
        ASSERT_EQ(forces[0].size() + forces[1].size(), static_cast<std::size_t>(2 * seq)) << "one waits";
        lockstep(seq % 2 == 0 ? 1 : 0, seq, depth_m);
        float at_m[2][3];
        for (std::size_t f = 0; f < 2; ++f) std::copy_n(to_finger(place(f, depth_m).data()).data(), 3, at_m[f]);
        haptable_pair_step(soft_pair().scene().pair, &pair, at_m[0], at_m[1], static_cast<std::uint32_t>(seq * 1000),
                           out);
        for (std::size_t f = 0; f < 2; ++f) {
            ASSERT_EQ(forces[f].size(), static_cast<std::size_t>(seq) + 1);
            EXPECT_EQ(forces[f].back().seq, seq);
            EXPECT_EQ(forces[f].back().utime, seq * 1000);
            EXPECT_EQ(forces[f].back().servo, forces[0].front().servo);
            for (int a = 0; a < 3; ++a) ASSERT_EQ(forces[f].back().force_n[a], double{out[f].force_n[a]}) << seq;
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

TEST_P(TwoFingers, OneIsFeltByTheOther) {
    press_both();
    const double before_n = forces[1].back().force_n[2];
    for (std::int64_t seq = 20; seq < 40; ++seq) {
        real(0, seq, 1e-4 * static_cast<double>(seq - 9));
        real(1, seq, 0.001);
        wait(milliseconds(1));
    }
    // The first's dent takes the surface away from the second, which has not moved.
    EXPECT_LT(forces[1].back().force_n[2], 0.99 * before_n);
}

// ---- one is late, or silent ---------------------------------------------------------------------------------------

TEST_P(TwoFingers, AStateWaitsAMillisecondForTheOthersAndNotAgain) {
    press_both();
    const std::size_t before = forces[0].size();
    real(0, 20, 0.0011);
    EXPECT_EQ(forces[0].size(), before) << "it waits";
    EXPECT_EQ(session->watch_at(), time.now() + kTick);
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
    for (std::int64_t seq = 20; seq < 45; ++seq) {
        real(0, seq, 0.001);
        wait(milliseconds(1));
    }
    ASSERT_EQ(forces[1].size(), answers + 1) << "told once";
    EXPECT_EQ(forces[1].back().servo_state, HAPTABLE_SILENT);
    EXPECT_EQ(forces[1].back().seq, 19);
    for (const double component : forces[1].back().force_n) EXPECT_EQ(component, 0.0);
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
    EXPECT_NE(told[0].find("finger 2: contact dropped after a silence of 20 ms"), std::string::npos) << told[0];
}

// It begins anew: inside, where nobody saw it come, it feels nothing; the first goes on in its contact.
TEST_P(TwoFingers, ADeviceThatRestartsInheritsNoContact) {
    press_both();
    for (std::int64_t seq = 20; seq < 45; ++seq) {
        real(0, seq, 0.001);
        wait(milliseconds(1));
    }
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
    lockstep(0, 0, -0.001);
    lockstep(1, 0, -0.001);
    for (std::int64_t seq = 1; seq < 30; ++seq)
        for (const std::size_t finger : {0U, 1U}) lockstep(finger, seq, 1e-4 * static_cast<double>(seq - 9));
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
    const std::size_t answers = forces[1].size();
    for (std::int64_t seq = 20; seq < 25; ++seq) {
        device_state theirs = state(1, seq, 0.001, device_state::REAL_TIME);
        theirs.session = 5;
        send(1, theirs);
        session->publish_status();
    }
    ASSERT_EQ(forces[1].size(), answers + 5);
    EXPECT_EQ(forces[1].back().session, 5);
    EXPECT_EQ(forces[1].back().owner, kSession + 1);
    for (const double component : forces[1].back().force_n) EXPECT_EQ(component, 0.0);
    EXPECT_EQ(status("other_device_states_2"), 5);
    EXPECT_EQ(status("other_device_states"), 0);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("finger 2: a second device"), std::string::npos) << told[0];
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

class TwoFingersOfOne : public SessionOfTwo, public testing::WithParamInterface<bool> {
protected:
    TwoFingersOfOne() : SessionOfTwo(GetParam(), soft_pair().scene_of_one()) {}
};
INSTANTIATE_TEST_SUITE_P(Behind, TwoFingersOfOne, testing::Bool(), name_of_place);

TEST_P(TwoFingersOfOne, AFingerThatTheSceneHasNotIsToldAndNotAnswered) {
    for (int twice = 0; twice < 2; ++twice) {
        send(1, simulated_state(twice, 1000 * twice));
        session->publish_status();
    }
    EXPECT_TRUE(forces[0].empty() && forces[1].empty());
    EXPECT_EQ(session->link_report().absent_finger_states, 2);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("fingers = 2"), std::string::npos) << told[0];
}

// ---- of a line alone ----------------------------------------------------------------------------------------------

class TwoBehindALine : public SessionOfTwo {
protected:
    TwoBehindALine() : SessionOfTwo(true, soft_pair().scene()) {}
    FakeTarget<Pipes>& target() { return behind->target; }
    /// An answer that is lost on its way.
    void lose_an_answer(std::int64_t seq, std::int8_t mode) {
        answers_by_itself = false;
        for (std::size_t finger = 0; finger < kTwo; ++finger) send(finger, state(finger, seq, 0.0011, mode));
        EXPECT_EQ(target().answer(true), 1);
        exchange();
        EXPECT_EQ(forces[0].back().seq, seq - 1);
    }
};

TEST_F(TwoBehindALine, InRealTimeAForceThatIsLostIsOvertaken) {
    press_both();
    const std::uint32_t ticks = target().counters(0).ticks;
    const std::size_t answers = forces[0].size();
    lose_an_answer(20, device_state::REAL_TIME);
    real(0, 21, 0.0011);
    real(1, 21, 0.0011);
    session->watch(Clock::now() + milliseconds(10));  // longer than the answer is waited for
    EXPECT_EQ(target().answer(), 1);
    exchange();
    EXPECT_EQ(forces[0].size(), answers + 1);
    EXPECT_EQ(forces[1].back().seq, 21);
    EXPECT_EQ(target().counters(0).ticks, ticks + 2);
    EXPECT_EQ(status("lost_answers"), 1);
    EXPECT_EQ(status("lost_answers_2"), 1);
}

TEST_F(TwoBehindALine, InLockstepATickIsSentAgainUntilItIsAnswered) {
    lockstep(0, 0, -0.001);
    lockstep(1, 0, -0.001);
    const std::uint32_t ticks = target().counters(0).ticks;
    lose_an_answer(1, device_state::SIMULATED);
    wait(milliseconds(50));
    EXPECT_EQ(target().answer(), 1);
    exchange();
    EXPECT_EQ(forces[0].back().seq, 1);
    EXPECT_EQ(forces[1].back().seq, 1);
    EXPECT_EQ(target().counters(0).ticks, ticks + 1);
    EXPECT_EQ(status("resent_frames"), 1);
}

// ---- two hands, their log and their record ------------------------------------------------------------------------

/// The first line in which two files differ; empty where none does.
std::string first_other(const std::filesystem::path& a, const std::filesystem::path& b) {
    const std::vector<std::string> ours = lines_of(read_file(a)), theirs = lines_of(read_file(b));
    for (std::size_t i = 0; i < std::min(ours.size(), theirs.size()); ++i)
        if (ours[i] != theirs[i]) return ours[i] + "\n" + theirs[i];
    return ours.size() == theirs.size() ? "" : "one ends before the other";
}

class TwoHands : public testing::Test {
protected:
    /// A pinch by two hands of one device, the servo's CSV and the session's log.
    std::array<DeviceReport, 2> run(bool lockstep, const std::string& faults, const std::string& tag,
                                    const ServoScene& scene) {
        SimulatedTime time;
        Connection connection("memq://");
        LogWriter log_writer(log(tag));
        const Recorder recorder(connection, log_writer);
        ServoRecord record(scene, csv(tag));
        LocalStepper stepper(scene);
        Session servo(stepper, connection, &record);
        time.also([&] { return servo.watch_at(); }, [&](Clock::time_point now) { servo.watch(now); });
        SessionOptions options;
        options.lockstep = lockstep;
        options.seconds = 1.0;
        if (!faults.empty()) options.faults = parse_faults(faults);
        std::array<std::unique_ptr<Path>, 2> path;
        std::array<std::unique_ptr<SimulatedDriver>, 2> driver;
        std::array<std::unique_ptr<DeviceSession>, 2> hand;
        for (std::size_t f = 0; f < 2; ++f) {
            PathOptions at;
            at.at_m = {f == 0 ? 0.0 : 0.03, 0.0143, 0.02};
            at.direction = {f == 0 ? 1.0 : -1.0, 0.0, 0.0};
            path[f] = scripted_path("poke", at);
            driver[f] =
                std::make_unique<SimulatedDriver>(PointDevice(Device{}, Hand{}, path[f]->at(0.0).position_m), *path[f]);
            options.finger = f;
            options.seed = 10 * (f + 1);
            hand[f] = std::make_unique<DeviceSession>(*driver[f], connection, options, nullptr);
        }
        run_together({hand[0].get(), hand[1].get()});
        handle_all(connection);
        record.finish();
        log_writer.finish();
        return {hand[0]->report(), hand[1]->report()};
    }
    void expect_same_again(const std::string& tag, const ServoScene& scene) {
        const ReplayReport report = replay(scene, log(tag), folder / "again.csv", true);
        EXPECT_EQ(report.other_forces, 0) << "the first at " << report.first_other;
        EXPECT_GT(report.compared, 1000);
        ASSERT_EQ(report.others.size(), 1U);
        EXPECT_GT(std::int64_t{report.counters.contact_ticks}, 10);
        EXPECT_GT(std::int64_t{report.others[0].counters.contact_ticks}, 10);
        EXPECT_EQ(first_other(folder / "again.csv", csv(tag)), "");
    }
    std::filesystem::path log(const std::string& tag) const { return folder / (tag + ".lcmlog"); }
    std::filesystem::path csv(const std::string& tag) const { return folder / (tag + ".csv"); }

    WorkFolder folder;
};

TEST_F(TwoHands, LockstepGivesTheSameBytesTwiceAndFromItsRecords) {
    const auto reports = run(true, "", "a", soft_pair().scene());
    for (const DeviceReport& report : reports) {
        EXPECT_EQ(report.missed, 0);
        EXPECT_EQ(report.resent, 0);
        EXPECT_GT(report.contact_ticks, 100);
        EXPECT_GT(report.largest_force_n, 0.1);
    }
    run(true, "", "b", soft_pair().scene());
    EXPECT_EQ(first_other(csv("a"), csv("b")), "");
    expect_same_again("a", soft_pair().scene());
    replay(soft_pair().scene(), csv("a"), folder / "of_csv.csv", true);
    EXPECT_EQ(first_other(folder / "of_csv.csv", csv("a")), "");
}

TEST_F(TwoHands, TheTableOfASessionHasBoth) {
    run(true, "", "a", soft_pair().scene());
    const Timeline timeline = read_timeline(log("a"));
    ASSERT_EQ(timeline.ticks.size(), 1000U);
    ASSERT_EQ(timeline.others.at(0).size(), 1000U);
    double largest_n = 0.0, stored_j = 0.0;
    for (const Tick& tick : timeline.others[0]) {
        EXPECT_TRUE(tick.answered);
        largest_n = std::fmax(largest_n, tick.force_size_n());
        stored_j = std::fmax(stored_j, tick.stored_j);
    }
    const ReplayReport report = replay(soft_pair().scene(), log("a"), "", true);
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

TEST_F(TwoHands, LockstepWithLostMessagesGivesTheSameBytes) {
    run(true, "", "whole", soft_pair().scene());
    const auto reports = run(true, "drop=0.03,double=0.05", "lossy", soft_pair().scene());
    EXPECT_GT(reports[0].resent + reports[1].resent, 5);
    EXPECT_EQ(first_other(csv("whole"), csv("lossy")), "");
    expect_same_again("lossy", soft_pair().scene());
}

TEST_F(TwoHands, RealTimeGivesTheSameForcesFromItsLog) {
    const auto reports = run(false, "", "a", soft_pair().scene());
    EXPECT_LT(reports[0].latency.max_us(), 1.0);  // of simulated time: neither waits for the other
    EXPECT_LT(reports[1].latency.max_us(), 1.0);
    expect_same_again("a", soft_pair().scene());
}

// Silences of either, lost and late states, positions that are none.
TEST_F(TwoHands, RealTimeWithFaultsGivesTheSameForcesFromItsLog) {
    const auto reports = run(false, "drop=0.02,reorder=0.02,gone=0.003:40ms,nan=0.002", "a", soft_pair().scene());
    EXPECT_GT(reports[0].silences, 0);
    EXPECT_GT(reports[1].silences, 0);
    expect_same_again("a", soft_pair().scene());
}

TEST_F(TwoHands, ABodyThatNothingHoldsMovesOnceATick) {
    haptable_body body = cube_body();
    add_gravity(body);
    add_floor(body, 0.0, 0.5);
    ServoScene loose = soft_pair().scene();
    loose.body = &body;
    run(true, "", "a", loose);
    expect_same_again("a", loose);
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
    const Timeline timeline = read_timeline(log("a"));
    double stored_j = 0.0, deepest_m = 0.0;
    for (const Tick& tick : timeline.ticks) {
        stored_j = std::fmax(stored_j, tick.stored_j);
        deepest_m = std::fmax(deepest_m, tick.depth_m);
    }
    const ReplayReport report = replay(loose, log("a"), "", true);
    EXPECT_LT(deepest_m, 0.006);
    EXPECT_WITHIN(std::abs(stored_j - report.energy.most_stored_j()), .count = 64, .epsilon = kFloat,
                  .condition = 0.03 / 0.004, .size = stored_j);
}

}  // namespace
}  // namespace haptable::test
