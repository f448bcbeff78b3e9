// SPDX-License-Identifier: GPL-2.0-or-later
// One finger on a soft box, in the closed loop: what both sides record, and that a log is a regression test.
#include <gtest/gtest.h>

#include <cmath>

#include "host/link/log_reader.hpp"
#include "tests/loop/limited_box.hpp"
#include "tests/loop/recorded_loop.hpp"

namespace haptable::test {
namespace {

class BoxLoop : public RecordedLoop {
protected:
    DeviceReport touch(const std::string& tag, const std::string& path, bool lockstep = true,
                       const std::string& faults = "") {
        SessionOptions options;
        options.lockstep = lockstep;
        if (!faults.empty()) options.faults = parse_faults(faults);
        return run(box.scene(), tag, {scripted_path(path, PathOptions{})}, options)[0];
    }

    SoftBox box;
};

// Of lockstep, states and answers that were lost and asked for again are no ticks; of real time, silence and what comes
// after it too. The servo's own record does not name its tables.
TEST_F(BoxLoop, IsTheSameAgainFromItsLogWhateverWasLost) {
    for (const auto& [lockstep, faults] : {std::pair{true, "drop=0.03,double=0.05"},
                                           {false, ""},
                                           {false, "drop=0.05,reorder=0.05,gone=0.003:40ms,nan=0.005"}}) {
        SCOPED_TRACE(faults);
        touch("a", "poke,drag", lockstep, faults);
        const ReplayReport report = expect_same_again("a", box.scene());
        EXPECT_EQ(report.compared, static_cast<std::int64_t>(lines_of(read_file(csv("a"))).size()) - 1);
        EXPECT_GT(std::int64_t{report.counters.contact_ticks}, 100);
    }
    EXPECT_EQ(read_recording(log("a")).tables_hash, SoftBox::kHash);
    EXPECT_EQ(read_recording(csv("a")).tables_hash, 0U);
}

// Time that leaps within a contact ends it, and so does another device that begins inside, whatever its time is.
TEST_F(BoxLoop, AReplayKnowsTimesAndSessions) {
    RecordedServo servo(box.scene(), csv("a"), log("a"));
    std::int64_t utime = 0;
    const auto tell = [&](std::int64_t session, std::int64_t seq, double z_m) {
        device_state state = simulated_state(seq, utime += 1000);
        state.session = session;
        std::copy_n(Eigen::Vector3d(0.0111, 0.0123, z_m).data(), 3, state.position_m);
        servo.tell(state);
    };
    for (int seq = 0; seq < 10; ++seq) tell(kSession, seq, 0.0301 - 1e-4 * seq);
    utime += 30'000;
    tell(kSession, 10, 0.0292);
    for (int seq = 11; seq < 20; ++seq) tell(kSession, seq, 0.0301 - 1e-4 * (seq - 11));
    servo.time.leap(servo.time.now() + std::chrono::seconds(2));
    tell(kSession + 1, 0, 0.0293);
    servo.finish();
    const auto rows = read_rows(csv("a"));
    ASSERT_EQ(rows.size(), 21U);
    for (const std::size_t tick : {9U, 10U, 19U, 20U}) EXPECT_EQ(rows[tick].at("contact"), tick % 10 == 9) << tick;
    EXPECT_EQ(replay(box.scene(), log("a"), folder / "again.csv", true).other_forces, 0);
    EXPECT_EQ(read_file(folder / "again.csv"), read_file(csv("a")));
}

// One bit of one force: it is seen, and where.
TEST_F(BoxLoop, AReplayTellsAnotherForce) {
    touch("a", "poke,drag");
    LogWriter other(log("other"));
    LogReader reader(log("a"));
    while (const auto event = reader.next()) {
        std::vector<std::uint8_t> data(event->data.begin(), event->data.end());
        servo_force force;
        if (event->channel == channel_of<servo_force>() && decode_whole(event->data, force) && force.seq == 400) {
            force.force_n[2] = static_cast<double>(std::nextafter(static_cast<float>(force.force_n[2]), 100.0F));
            force.encode(data.data(), 0, static_cast<int>(data.size()));
        }
        other.add(event->channel, data, event->utime);
    }
    other.finish();
    const ReplayReport report = replay(box.scene(), log("other"), csv("other"), true);
    EXPECT_EQ(report.other_forces, 1);
    EXPECT_EQ(report.first_other, 400);
}

// A device that nobody answers has a path all the same; a log without states has none.
TEST_F(BoxLoop, ALogWithoutAServoHasItsStates) {
    LogWriter lonely(log("lonely")), empty(log("empty"));
    for (int seq = 0; seq < 5; ++seq) {
        const auto data = encoded(simulated_state(seq, 1000 * seq));
        for (int twice = 0; twice < 2; ++twice) lonely.add(channel_of<device_state>(), data, 1000 * seq);
    }
    lonely.finish();
    const Recording recording = read_recording(log("lonely"));
    ASSERT_EQ(recording.ticks.size(), 5U);
    EXPECT_EQ(recording.ticks[4].number, 4);
    EXPECT_FALSE(recording.ticks[4].finger[0]->force_n);
    empty.add("OTHER", {}, 1);
    empty.finish();
    EXPECT_THROW(read_recording(log("empty")), Error);
}

// The state machine behind messages: down, along, a glitch of the encoder, a grab that is held on the way out and
// pulls.
TEST_F(BoxLoop, AReplayGivesWhatEveryLimitMadeOfTheLiveSession) {
    const LimitedBox limited;
    RecordedServo servo(limited.scene(), csv("live"), log("live"));
    for (int tick = 0; tick < 1000; ++tick) {
        const double s = tick / 1000.0, glitch_m = tick == 300 ? 0.025 : 0.0;
        device_state state = simulated_state(tick, tick * 1000);
        std::copy_n(Eigen::Vector3d(0.008 + 0.01 * s, 0.013, 0.0305 - 0.004 * std::sin(8.0 * s) - glitch_m).data(), 3,
                    state.position_m);
        state.buttons = tick > 370 && tick < 430 ? HAPTABLE_BUTTON_GRAB : 0;
        servo.tell(state);
    }
    const haptable_counters counters = servo.stepper.report().counters;
    servo.finish();
    expect_same_again("live", limited.scene());
    EXPECT_EQ(counters.ticks, 1000U);
    EXPECT_EQ(counters.implausible, 2U);
    EXPECT_GT(counters.limited_ticks, 0U);
    EXPECT_GT(counters.grabbed_ticks, 0U);
}

TEST_F(BoxLoop, DamagedTablesBeginNoSession) {
    LimitedBox limited;
    limited.model().crc ^= 1U;
    EXPECT_THROW(LocalStepper(limited.scene()), Error);
    write_file(folder / "path.csv", "x,y,z\n0,0,0\n");
    EXPECT_THROW(replay(limited.scene(), folder / "path.csv", folder / "out.csv", true), Error);
}

}  // namespace
}  // namespace haptable::test
