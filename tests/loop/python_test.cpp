// SPDX-License-Identifier: GPL-2.0-or-later
// The Python device of docs/LOOP.md, with PyPI's lcm, as it stands there: the forces that it prints are the servo's.
// Skipped where LCM has no multicast route or PyPI could not be reached (make test makes build/python).
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

#include "host/base/error.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// The first block of the page in that language.
std::string code_of(const std::filesystem::path& page, const std::string& language) {
    const std::string text = read_file(page), fence = "```" + language + "\n";
    const std::size_t begin = text.find(fence);
    if (begin == std::string::npos) return "";
    return text.substr(begin + fence.size(), text.find("```", begin + fence.size()) - begin - fence.size());
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

TEST(PythonDevice, OfThePageFeelsTheServo) {
    const std::string url = "udpm://239.255.72.84:" + std::to_string(20000 + getpid() % 20000) + "?ttl=0";
    const std::filesystem::path python = std::filesystem::absolute(build_folder()) / "python";
    const std::string servo = (build_folder() / "cube/servo").string();
    if (!std::filesystem::exists(python / "ready")) GTEST_SKIP() << "the packages of PyPI are not there: make test installs them";
    if (!std::filesystem::exists(servo)) GTEST_SKIP() << servo << " is not built: make scene";
    try {
        const Connection connection(url);
    } catch (const Error& error) {
        GTEST_SKIP() << error.what();
    }
    const WorkFolder folder;
    write_file(folder / "device.py", replaced(code_of("docs/LOOP.md", "python"), kDefaultUrl, url));
    Process servo_process({"env", "LCM_DEFAULT_URL=" + url, servo, "--lcm", "--quiet", "--no-realtime", "--csv",
                           (folder / "servo.csv").string()});
    const Outcome device = run("PYTHONPATH=" + (python / "types").string() + " " + (python / "bin/python").string() +
                                   " " + (folder / "device.py").string(),
                               {}, std::chrono::seconds(120));
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

}  // namespace
}  // namespace haptable::test
