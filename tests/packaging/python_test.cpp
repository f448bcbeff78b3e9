// SPDX-License-Identifier: GPL-2.0-or-later
// The Python package from nothing: a clean venv, pip install ., and its own tests, with a log of our writer.
// Skipped where PyPI could not be reached (make test makes build/python).
#include <gtest/gtest.h>

#include "host/link/log_writer.hpp"
#include "host/link/messages.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/wheels.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

template <typename Message>
void write(LogWriter& log, std::int64_t utime, const char* channel, const Message& message) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    log.add(channel, bytes, utime);
}

void write_log(const fs::path& file) {
    LogWriter log(file);
    device_state state{};
    state.position_m[0] = 0.25;
    state.position_m[1] = -0.5;
    state.position_m[2] = 1.0;
    write(log, 1, kStateChannel, state);
    servo_force force{};
    force.seq = 7;
    force.force_n[2] = 1.5F;
    write(log, 2, kForceChannel, force);
    contact touch{};
    touch.count = 2;
    touch.node = {3, 5};
    touch.force_n = {{1, 2, 3}, {4, 5, 6}};
    write(log, 3, kContactChannel, touch);
    const std::vector<std::uint8_t> other{'b', 'y', 't', 'e', 's'};
    log.add("OTHER", other, 4);
    log.finish();
}

TEST(PythonPackage, PassesItsTestsInACleanVenv) {
    if (!fs::exists(build_folder() / "cube/servo")) GTEST_SKIP() << "build/cube/servo is not built: make scene";
    if (!has_wheels()) GTEST_SKIP() << kNoWheels;
    const TemporaryFolder folder;
    const std::string venv = (folder.path() / "venv").string(), log = (folder.path() / "session.lcmlog").string();
    const Outcome installed = run("python3 -m venv " + venv + " && " + pip_of_wheels() + venv +
                                  "/bin/pip install --quiet --disable-pip-version-check .");
    ASSERT_EQ(installed.status, 0) << installed.err;
    write_log(log);
    const Outcome tested = run("HAPTABLE_LOG=" + log + " BUILD=" + build_folder().string() + " " + venv +
                               "/bin/python python/tests/test_haptable.py");
    EXPECT_EQ(tested.status, 0) << tested.err;
    EXPECT_EQ(tested.err.find("skipped"), std::string::npos) << tested.err;

    // The notebook, in a folder with these tables, so that its page does not come into the source tree.
    fs::create_directories(folder.path() / "work/build");
    fs::create_directory_symlink(fs::absolute(build_folder() / "cube"), folder.path() / "work/build/cube");
    const Outcome notebook = run(
        pip_of_wheels() + venv + "/bin/pip install --quiet --disable-pip-version-check nbclient ipykernel && " + venv +
        "/bin/python python/tests/run_notebook.py python/examples/touch.ipynb " + (folder.path() / "work").string());
    EXPECT_EQ(notebook.status, 0) << notebook.err;
    EXPECT_EQ(notebook.out, "5 cells ran\n");
    EXPECT_TRUE(fs::exists(folder.path() / "work/press.html"));
}

}  // namespace
}  // namespace haptable::test
