// SPDX-License-Identifier: GPL-2.0-or-later
// A log is a regression test: the servo gives its forces again, bit for bit, from the log alone.
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/device/session.hpp"
#include "host/link/log_reader.hpp"
#include "host/link/log_writer.hpp"
#include "host/run/recorder.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

class LogReplay : public testing::Test {
protected:
    /// A session in simulated time, its log and its servo's CSV.
    void record(bool lockstep, const std::string& faults) {
        SimulatedTime time;
        Connection connection("memq://");
        LogWriter log_writer(log);
        const Recorder recorder(connection, log_writer);
        ServoRecord servo_record(box.scene(), csv);
        LocalStepper stepper(box.scene());
        Session servo(stepper, connection, &servo_record);
        time.also([&] { return servo.watch_at(); }, [&](Clock::time_point now) { servo.watch(now); });
        const auto path = scripted_path("poke,drag", PathOptions{});
        SessionOptions options;
        options.lockstep = lockstep;
        options.seconds = 1.8;
        if (!faults.empty()) options.faults = parse_faults(faults);
        DeviceSession(PointDevice(Device{}, Hand{}, path->at(0.0).position_m), *path, connection, options, nullptr)
            .run();
        handle_all(connection);
        servo_record.finish();
        log_writer.finish();
    }
    ReplayReport replay_to(const std::filesystem::path& in, const std::string& out) {
        return replay(box.scene(), in, folder / out, true);
    }
    /// The session again from the log.
    void expect_same_again() {
        const ReplayReport report = replay_to(log, "of_log.csv");
        EXPECT_EQ(report.other_forces, 0);
        EXPECT_EQ(report.compared, static_cast<std::int64_t>(lines_of(read_file(csv)).size()) - 1);
        EXPECT_GT(std::int64_t{report.counters.contact_ticks}, 100);
        EXPECT_EQ(read_file(folder / "of_log.csv"), read_file(csv));
    }

    SoftBox box;
    WorkFolder folder;
    std::filesystem::path log = folder / "session.lcmlog", csv = folder / "servo.csv";
};

// And so does the servo's own record, which does not name its tables.
TEST_F(LogReplay, OfLockstepGivesTheSameBytes) {
    record(true, "");
    expect_same_again();
    EXPECT_EQ(read_recording(log).tables_hash, SoftBox::kHash);
    replay_to(csv, "of_csv.csv");
    EXPECT_EQ(read_file(folder / "of_csv.csv"), read_file(csv));
    EXPECT_EQ(read_recording(csv).tables_hash, 0U);
}

// States and answers that were lost and asked for again are no ticks.
TEST_F(LogReplay, OfLockstepWithLostMessagesGivesTheSameBytes) {
    record(true, "drop=0.03,double=0.05");
    expect_same_again();
}

TEST_F(LogReplay, OfRealTimeGivesTheSameForces) {
    record(false, "");
    expect_same_again();
}

// Silence and what comes after it, too.
TEST_F(LogReplay, OfRealTimeWithFaultsGivesTheSameForces) {
    record(false, "drop=0.05,reorder=0.05,gone=0.003:40ms,nan=0.005");
    expect_same_again();
}

// Time that leaps within a contact ends it, and so does another device that begins inside, whatever its time is.
TEST_F(LogReplay, KnowsTimesAndSessions) {
    SimulatedTime time;
    Connection connection("memq://");
    LogWriter log_writer(log);
    const Recorder recorder(connection, log_writer);
    ServoRecord servo_record(box.scene(), csv);
    LocalStepper stepper(box.scene());
    const Session servo(stepper, connection, &servo_record);
    std::int64_t utime = 0;
    const auto tell = [&](std::int64_t session, std::int64_t seq, double z_m) {
        device_state state = simulated_state(seq, utime += 1000);
        state.session = session;
        state.position_m[0] = 0.0111, state.position_m[1] = 0.0123, state.position_m[2] = z_m;
        connection.publish(channel_of<device_state>(), state);
        handle_all(connection);
    };
    for (int seq = 0; seq < 10; ++seq) tell(kSession, seq, 0.0301 - 1e-4 * seq);
    utime += 30'000;
    tell(kSession, 10, 0.0292);
    for (int seq = 11; seq < 20; ++seq) tell(kSession, seq, 0.0301 - 1e-4 * (seq - 11));
    time.leap(time.now() + std::chrono::seconds(2));
    tell(kSession + 1, 0, 0.0293);
    servo_record.finish();
    log_writer.finish();
    const auto rows = read_rows(csv);
    ASSERT_EQ(rows.size(), 21U);
    for (const std::size_t tick : {9U, 10U, 19U, 20U}) EXPECT_EQ(rows[tick].at("contact"), tick % 10 == 9) << tick;
    EXPECT_EQ(replay_to(log, "again.csv").other_forces, 0);
    EXPECT_EQ(read_file(folder / "again.csv"), read_file(csv));
}

// One bit of one force: it is seen, and where.
TEST_F(LogReplay, TellsAnotherForce) {
    record(true, "");
    LogWriter other(folder / "other.lcmlog");
    LogReader reader(log);
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
    const ReplayReport report = replay_to(folder / "other.lcmlog", "other.csv");
    EXPECT_EQ(report.other_forces, 1);
    EXPECT_EQ(report.first_other, 400);
}

// A device that nobody answers has a path all the same.
TEST_F(LogReplay, OfALogWithoutAServoTakesItsStates) {
    LogWriter lonely(log);
    for (int seq = 0; seq < 5; ++seq) {
        const device_state state = simulated_state(seq, 1000 * seq);
        std::vector<std::uint8_t> data(static_cast<std::size_t>(state.getEncodedSize()));
        state.encode(data.data(), 0, static_cast<int>(data.size()));
        for (int twice = 0; twice < 2; ++twice) lonely.add(channel_of<device_state>(), data, 1000 * seq);
    }
    lonely.finish();
    const Recording recording = read_recording(log);
    ASSERT_EQ(recording.ticks.size(), 5U);
    EXPECT_EQ(recording.ticks[4].number, 4);
    EXPECT_FALSE(recording.ticks[4].finger[0]->force_n);
}

TEST_F(LogReplay, OfALogWithoutStatesIsAnError) {
    LogWriter empty(log);
    empty.add("OTHER", {}, 1);
    empty.finish();
    EXPECT_THROW(read_recording(log), Error);
}

}  // namespace
}  // namespace haptable::test
