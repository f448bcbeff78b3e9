// SPDX-License-Identifier: GPL-2.0-or-later
// The Python programs of docs/LOOP.md and README.md, with PyPI's lcm, as they stand there: what they print is the
// servo's. Skipped where LCM has no multicast route or PyPI could not be reached (make test makes build/python).
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <map>

#include "host/base/error.hpp"
#include "host/link/log_reader.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"
#include "tests/wheels.hpp"

namespace haptable::test {
namespace {

/// The first block of the page in that language.
std::string code_of(const std::filesystem::path& page, const std::string& language) {
    const std::string text = read_file(page), fence = "```" + language + "\n";
    const std::size_t begin = text.find(fence);
    if (begin == std::string::npos) return "";
    return text.substr(begin + fence.size(), text.find("```", begin + fence.size()) - begin - fence.size());
}

class Python : public testing::Test {
protected:
    void SetUp() override {
        setenv("LCM_DEFAULT_URL", url.c_str(), 1);
        if (!has_wheels()) GTEST_SKIP() << kNoWheels;
        if (!std::filesystem::exists(servo)) GTEST_SKIP() << servo << " is not built: make scene";
        if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << why;
    }
    void TearDown() override { unsetenv("LCM_DEFAULT_URL"); }

    /// The command that runs a page's program.
    std::string command_of(const std::string& page) const {
        write_file(folder / "program.py", code_of(page, "python"));
        return "PYTHONPATH=" + (python / "types").string() + " " + (python / "bin/python").string() + " -u " +
               (folder / "program.py").string();
    }
    std::vector<std::string> servo_command(const std::string& csv) const {
        return {servo, "--lcm", "--quiet", "--no-realtime", "--csv", (folder / csv).string()};
    }

    std::string url = own_url();
    std::filesystem::path python = std::filesystem::absolute(build_folder()) / "python";
    std::string servo = (build_folder() / "cube/servo").string();
    WorkFolder folder;
};

TEST_F(Python, TheDeviceOfThePageFeelsTheServo) {
    Process servo_process(servo_command("servo.csv"));
    const Outcome device = run(command_of("docs/LOOP.md"), {}, std::chrono::seconds(120));
    ASSERT_EQ(device.status, 0) << device.err;
    servo_process.kill(SIGTERM);
    ASSERT_EQ(servo_process.wait_for_exit(), 0);
    const auto rows = read_rows(folder / "servo.csv");
    const auto said = lines_of(device.out);
    ASSERT_EQ(rows.size(), 1000U);
    ASSERT_EQ(said.size(), 1000U);
    double largest_n = 0.0;
    for (std::size_t i = 0; i < said.size(); ++i) {
        std::istringstream numbers(said[i]);
        for (std::size_t a = 0; a < 3; ++a) {
            double force_n = 0.0;
            numbers >> force_n;
            ASSERT_EQ(static_cast<float>(force_n), static_cast<float>(rows[i][14 + a])) << i;
            largest_n = std::max(largest_n, force_n);
        }
    }
    EXPECT_GT(largest_n, 0.1);
}

// README's listener hears a session without being told where it is: every line is a tick of the servo's record.
TEST_F(Python, TheListenerOfTheReadmeHearsASession) {
    Process listener({"sh", "-c", "exec env " + command_of("README.md")},
                     {{}, (folder / "heard").string(), (folder / "complaints").string()});
    Process servo_process(servo_command("servo.csv"));
    const std::string device = program("haptable-device").string() + " meshes/cube.toml --quiet --no-realtime";
    const auto give_up = Clock::now() + std::chrono::seconds(60);
    // Python takes a moment to listen, and may come in at a session's end.
    while (lines_of(read_file(folder / "heard")).size() <= 10 && Clock::now() < give_up)
        ASSERT_EQ(run(device + " --lockstep --seconds 0.3").status, 0);
    listener.kill(SIGKILL);
    listener.wait_for_exit();
    servo_process.kill(SIGTERM);
    ASSERT_EQ(servo_process.wait_for_exit(), 0);
    const auto rows = read_rows(folder / "servo.csv");
    const auto heard = lines_of(read_file(folder / "heard"));
    ASSERT_GT(heard.size(), 10U) << read_file(folder / "complaints");
    for (const std::string& line : heard) {
        std::istringstream words(line);
        std::size_t seq = 0;
        double finger_z = 0.0;
        words >> seq >> finger_z;
        ASSERT_LT(seq, rows.size());
        EXPECT_EQ(static_cast<float>(finger_z), static_cast<float>(rows[seq][3])) << line;
    }
}

// A user's lcm-logger, which knows nothing of haptable, records a session that was told no URL either.
TEST_F(Python, LcmLoggerHearsASessionOfTheDefaultUrl) {
    const std::string log_file = (folder / "session.lcmlog").string();
    const std::string device = program("haptable-device").string() + " meshes/cube.toml --quiet --no-realtime";
    write_file(folder / "session.sh",
               "unset LCM_DEFAULT_URL\n"
               "lcm-logger -q -f " +
                   log_file + " & logger=$!\n" + servo +
                   " --lcm --quiet --no-realtime & servo=$!\n"
                   "for try in $(seq 50); do\n" +  // until the logger listens
                   device +
                   " --seconds 0.3 || exit 1\n" + "[ -s " + log_file +
                   " ] && break; done\n"
                   "kill $logger $servo; wait $logger; wait $servo\n");
    const Outcome session = run("sh scripts/loopback.sh sh " + (folder / "session.sh").string());
    EXPECT_EQ(session.status, 0) << session.err;
    LogReader log(log_file);
    std::map<std::string, int> heard;  // on a busy machine not all
    while (const auto event = log.next()) ++heard[std::string(event->channel)];
    for (const char* channel : {channel_of<device_state>(), channel_of<servo_force>(), channel_of<contact>()})
        EXPECT_GT(heard[channel], 0) << channel;
}

}  // namespace
}  // namespace haptable::test
