// SPDX-License-Identifier: GPL-2.0-or-later
// The closed loop within one process, over memq:// and in simulated time: the code of all programs, no network. What
// each side records, and the session again from that.
#pragma once

#include <gtest/gtest.h>

#include "host/device/session.hpp"
#include "host/device/simulated_driver.hpp"
#include "host/link/log_writer.hpp"
#include "host/run/recorder.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {

/// A servo, its CSV and the session's log.
struct RecordedServo {
    RecordedServo(const ServoScene& scene, const std::filesystem::path& csv, const std::filesystem::path& log)
        : log_writer(log), record(scene, csv), stepper(scene) {
        time.also([this] { return session.watch_at(); }, [this](Clock::time_point now) { session.watch(now); });
    }
    void tell(const device_state& state) {
        connection.publish(channel_of<device_state>(), state);
        handle_all(connection);
    }
    void finish() {
        session.publish_status();
        handle_all(connection);
        record.finish();
        log_writer.finish();
    }

    SimulatedTime time;
    Connection connection{"memq://"};
    LogWriter log_writer;
    const Recorder recorder{connection, log_writer};
    ServoRecord record;
    LocalStepper stepper;
    Session session{stepper, connection, &record};
};

class RecordedLoop : public testing::Test {
protected:
    std::filesystem::path csv(const std::string& tag) const { return folder / (tag + ".csv"); }
    std::filesystem::path device_csv(const std::string& tag) const { return folder / (tag + "-device.csv"); }
    std::filesystem::path log(const std::string& tag) const { return folder / (tag + ".lcmlog"); }

    /// Hands along their paths; the first one's record is kept.
    std::vector<DeviceReport> run(const ServoScene& scene, const std::string& tag,
                                  const std::vector<std::shared_ptr<Path>>& paths, SessionOptions options) const {
        RecordedServo servo(scene, csv(tag), log(tag));
        DeviceRecord device_record(device_csv(tag), options.has_tool);
        std::vector<std::unique_ptr<SimulatedDriver>> drivers;
        std::vector<std::unique_ptr<DeviceSession>> hands;
        std::vector<DeviceSession*> all;
        for (const auto& path : paths) {
            drivers.push_back(std::make_unique<SimulatedDriver>(
                PointDevice(Device{}, haptable::Hand{}, path->at(0.0).position_m), *path));
            options.finger = hands.size();
            options.seed = 10 * (options.finger + 1);
            hands.push_back(std::make_unique<DeviceSession>(*drivers.back(), servo.connection, options,
                                                            hands.empty() ? &device_record : nullptr));
            all.push_back(hands.back().get());
        }
        run_together(all);
        servo.finish();
        device_record.finish();
        std::vector<DeviceReport> reports;
        for (const auto& hand : hands) reports.push_back(hand->report());
        return reports;
    }
    /// The session again from its log and from its servo's CSV: bit for bit.
    ReplayReport expect_same_again(const std::string& tag, const ServoScene& scene) const {
        const ReplayReport report = replay(scene, log(tag), folder / "again.csv", true);
        EXPECT_EQ(report.other_forces, 0) << "the first at " << report.first_other;
        EXPECT_GT(report.compared, 0);
        EXPECT_GT(std::int64_t{report.counters.contact_ticks}, 10);
        EXPECT_EQ(first_other(folder / "again.csv", csv(tag)), "");
        replay(scene, csv(tag), folder / "of_csv.csv", true);
        EXPECT_EQ(first_other(folder / "of_csv.csv", csv(tag)), "");
        return report;
    }
    /// The first line in which two files differ; empty where none does.
    static std::string first_other(const std::filesystem::path& a, const std::filesystem::path& b) {
        const std::vector<std::string> ours = lines_of(read_file(a)), theirs = lines_of(read_file(b));
        for (std::size_t i = 0; i < std::min(ours.size(), theirs.size()); ++i)
            if (ours[i] != theirs[i]) return ours[i] + "\n" + theirs[i];
        return ours.size() == theirs.size() ? "" : "one ends before the other";
    }

    WorkFolder folder;
};

}  // namespace haptable::test
