// SPDX-License-Identifier: GPL-2.0-or-later
// The closed loop over real LCM: the servo of the paper's cube and the simulated device, as users start them.
// Skipped where LCM has no multicast route (run these under scripts/loopback.sh) or the programs are not built.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <thread>

#include "host/base/error.hpp"
#include "host/link/messages.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// Pokes for a minute: after a stall, which drops the contact, the next poke makes a new one.
const std::vector<std::string> kPokes = {"--path", "poke", "--hold", "0.3", "--seconds", "60"};

class LcmLoop : public testing::Test {
protected:
    void SetUp() override {
        url = own_url();
        setenv("LCM_DEFAULT_URL", url.c_str(), 1);
        for (const std::string& program : {servo, device})
            if (!std::filesystem::exists(program)) GTEST_SKIP() << program << " is not built: make scene";
        try {
            connection = std::make_unique<Connection>(url);
            connection->subscribe<servo_force>(channel_of<servo_force>(),
                                               [this](const servo_force& force, std::int64_t) {
                                                   if (std::abs(force.force_n[2]) > 0.1) ++pressed;
                                                   if (force.servo_state == servo_force::SILENT)
                                                       silent.push_back(force);
                                               });
        } catch (const Error& error) {
            GTEST_SKIP() << error.what();
        }
    }
    void TearDown() override { unsetenv("LCM_DEFAULT_URL"); }

    std::vector<std::string> servo_command(const std::string& record) const {
        return {servo, "--lcm", "--quiet", "--no-realtime", "--csv", (folder / record).string()};
    }
    std::vector<std::string> device_command(const std::string& record, const std::vector<std::string>& more) const {
        std::vector<std::string> command = {device, "meshes/cube.toml", "--quiet", "--no-realtime", "--csv"};
        command.push_back((folder / record).string());
        command.insert(command.end(), more.begin(), more.end());
        return command;
    }
    /// A session in lockstep, recorded by both sides.
    void run_in_lockstep(const std::string& tag) {
        Process servo_process(servo_command("servo_" + tag + ".csv"));
        Process device_process(device_command("device_" + tag + ".csv", {"--lockstep", "--path", "poke,drag"}));
        ASSERT_EQ(device_process.wait_for_exit(), 0);
        servo_process.kill(SIGTERM);
        ASSERT_EQ(servo_process.wait_for_exit(), 0);
    }
    /// Handles messages until `done` or 30 s have passed.
    template <typename Done>
    bool handle_until(Done done) {
        const Clock::time_point give_up = Clock::now() + std::chrono::seconds(30);
        while (!done() && Clock::now() < give_up) connection->handle_until(give_up);
        return done();
    }

    /// Waits until the servo has answered with a force for some time.
    bool handle_until_pressed() {
        pressed = 0;
        return handle_until([this] { return pressed > 50; });
    }

    std::string servo = build_folder() / "cube/servo";
    std::string device = program("haptable-device");
    std::string url;
    WorkFolder folder;
    std::unique_ptr<Connection> connection;
    std::int64_t pressed = 0;         // answers with a force
    std::vector<servo_force> silent;  // answers of a servo that has fallen silent
};

// A poke and a drag: every tick answered in order, no message lost, contact reached and left.
TEST_F(LcmLoop, AnswersEveryTickInOrder) {
    run_in_lockstep("a");
    const auto rows = read_rows(folder / "servo_a.csv"), device_rows = read_rows(folder / "device_a.csv");
    ASSERT_GT(rows.size(), 1500U);
    ASSERT_EQ(device_rows.size(), rows.size());
    std::size_t touching = 0;
    double largest_n = 0.0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        ASSERT_EQ(rows[i][0], static_cast<double>(i));
        ASSERT_EQ(device_rows[i][13], static_cast<double>(i));
        for (std::size_t a = 0; a < 3; ++a)
            ASSERT_EQ(static_cast<float>(rows[i][14 + a]), static_cast<float>(device_rows[i][10 + a])) << i;
        touching += rows[i][4] > 0.0 ? 1 : 0;
        largest_n = std::max(largest_n, std::hypot(rows[i][14], rows[i][15], rows[i][16]));
    }
    EXPECT_EQ(rows.front()[4], 0.0);
    EXPECT_EQ(rows.back()[4], 0.0);
    EXPECT_GT(touching, 500U);
    // A cube of 10 kPa and 30 mm under a hand 5 mm deep: tenths of a newton, less than the hand alone can press.
    EXPECT_GT(largest_n, 0.1);
    EXPECT_LT(largest_n, 200.0 * 0.005);
}

// The forces of the loop are those of the recorded finger path without any loop.
TEST_F(LcmLoop, GivesTheForcesOfAReplay) {
    run_in_lockstep("a");
    write_file(folder / "path.csv", finger_path_of(folder / "servo_a.csv"));
    Process replay(
        {servo, "--quiet", "--replay", (folder / "path.csv").string(), "--out", (folder / "replay.csv").string()});
    ASSERT_EQ(replay.wait_for_exit(), 0);
    EXPECT_EQ(read_file(folder / "replay.csv"), read_file(folder / "servo_a.csv"));
}

TEST_F(LcmLoop, MakesTheSameBytesTwice) {
    run_in_lockstep("a");
    run_in_lockstep("b");
    EXPECT_EQ(read_file(folder / "servo_a.csv"), read_file(folder / "servo_b.csv"));
    EXPECT_EQ(read_file(folder / "device_a.csv"), read_file(folder / "device_b.csv"));
}

// In real time: the servo dies in the middle of a press, and 20 ms later the device gives no force. On a busy machine
// the press may be over when the signal comes: then again.
TEST_F(LcmLoop, DeviceGivesNoForceWithoutServo) {
    for (int tries = 0; tries < 10; ++tries) {
        Process servo_process(servo_command("servo.csv"));
        Process device_process(device_command("device.csv", kPokes));
        ASSERT_TRUE(handle_until_pressed());
        servo_process.kill(SIGKILL);
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        device_process.kill(SIGTERM);
        ASSERT_EQ(device_process.wait_for_exit(), 0);
        const auto rows = read_rows(folder / "device.csv");
        std::size_t last_answer = 0;
        for (std::size_t i = 1; i < rows.size(); ++i)
            if (rows[i][13] > rows[i - 1][13]) last_answer = i;
        if (std::abs(rows[last_answer][12]) < 0.1 || last_answer + 50 > rows.size()) continue;
        // A tick of the device takes a millisecond or, on a busy machine, more: never less.
        for (std::size_t i = last_answer + 22; i < rows.size(); ++i) ASSERT_EQ(rows[i][12], 0.0) << i;
        return;
    }
    FAIL() << "the servo was never killed within a press";
}

// In real time: the device dies in the middle of a press, and the servo says zero force once it has been silent.
TEST_F(LcmLoop, ServoGivesNoForceWithoutDevice) {
    Process servo_process(servo_command("servo.csv"));
    Process device_process(device_command("device.csv", kPokes));
    ASSERT_TRUE(handle_until_pressed());
    silent.clear();  // of a stall while the session was running
    device_process.kill(SIGKILL);
    device_process.wait_for_exit();
    ASSERT_TRUE(handle_until([&] { return !silent.empty(); }));
    for (const double component : silent.front().force_n) EXPECT_EQ(component, 0.0);
    servo_process.kill(SIGTERM);
    EXPECT_EQ(servo_process.wait_for_exit(), 0);
    // The record of an ended servo is whole.
    EXPECT_GT(read_rows(folder / "servo.csv").size(), 50U);
}

}  // namespace
}  // namespace haptable::test
