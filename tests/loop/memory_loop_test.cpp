// SPDX-License-Identifier: GPL-2.0-or-later
// The closed loop within this process, over memq://: the code of both programs, no network, no clock.
#include <gtest/gtest.h>

#include <cmath>

#include "host/device/session.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/session.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

class MemoryLoop : public testing::Test {
protected:
    /// One session in lockstep, recorded by both sides.
    DeviceReport run(const std::string& names, const std::string& tag) {
        Connection connection("memq://");
        const auto path = scripted_path(names, PathOptions{});
        ServoRecord servo_record(box.scene(), folder / ("servo_" + tag + ".csv"));
        DeviceRecord device_record(folder / ("device_" + tag + ".csv"));
        const PointDevice device(Device{}, Hand{}, path->at(0.0).position_m);
        SessionOptions options;
        options.lockstep = true;
        LocalStepper stepper(box.scene());
        Session servo(stepper, connection, &servo_record);
        DeviceSession session(device, *path, connection, options, &device_record);
        const DeviceReport report = session.run();
        servo_record.finish();
        device_record.finish();
        return report;
    }

    SoftBox box;
    WorkFolder folder;
};

TEST_F(MemoryLoop, TouchesSlidesAndLeaves) {
    const DeviceReport report = run("poke,drag,circle", "a");
    EXPECT_EQ(report.missed, 0);
    EXPECT_EQ(report.foreign_answers, 0);
    EXPECT_GT(report.contact_ticks, 800);
    const auto rows = read_rows(folder / "servo_a.csv");
    ASSERT_EQ(rows.size(), static_cast<std::size_t>(report.ticks));
    int touched = 0;
    for (std::size_t i = 1; i < rows.size(); ++i) touched += rows[i].at("contact") > rows[i - 1].at("contact") ? 1 : 0;
    EXPECT_EQ(touched, 3);
    EXPECT_EQ(rows.front().at("contact"), 0.0);
    EXPECT_EQ(rows.back().at("contact"), 0.0);
}

// The two sides saw the same: positions of the device, forces of the servo.
TEST_F(MemoryLoop, BothRecordsAgree) {
    run("poke,circle", "a");
    const auto servo = read_rows(folder / "servo_a.csv"), device = read_rows(folder / "device_a.csv");
    ASSERT_EQ(servo.size(), device.size());
    for (std::size_t i = 0; i < servo.size(); ++i) {
        for (const char* of : {"", "force_"})
            EXPECT_EQ(xyz_of(servo[i], of).cast<float>(), xyz_of(device[i], of).cast<float>());
        EXPECT_EQ(device[i].at("answered_tick"), static_cast<double>(i));
    }
}

// Nothing depends on time, memory or luck.
TEST_F(MemoryLoop, MakesTheSameBytesTwice) {
    run("poke,drag,circle", "a");
    run("poke,drag,circle", "b");
    EXPECT_EQ(read_file(folder / "servo_a.csv"), read_file(folder / "servo_b.csv"));
    EXPECT_EQ(read_file(folder / "device_a.csv"), read_file(folder / "device_b.csv"));
}

// The hand presses a body whose point stiffness is 50 to some 110 N/m: the force is in that range.
TEST_F(MemoryLoop, ForceIsThatOfHandAndBodyInSeries) {
    const DeviceReport report = run("poke", "a");
    const double soft_n = 200.0 * 50.0 / 250.0 * 0.005, hard_n = 200.0 * 200.0 / 400.0 * 0.005;
    EXPECT_GT(report.largest_force_n, soft_n - 0.04);
    EXPECT_LT(report.largest_force_n, hard_n * 1.2);
}

}  // namespace
}  // namespace haptable::test
