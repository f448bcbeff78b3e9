// SPDX-License-Identifier: GPL-2.0-or-later
// The Python package from nothing: a clean venv, pip install ., and its own tests, with a log of our writer.
// Skipped where PyPI could not be reached (make test makes build/python).
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "host/link/log_writer.hpp"
#include "host/link/messages.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/wheels.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

// What each type is known by again.
void fill(device_state& state) {
    state.position_m[0] = 0.25;
    state.position_m[1] = -0.5;
    state.position_m[2] = 1.0;
}
void fill(servo_force& force) { force.force_n[2] = 1.5; }
void fill(body_pose& pose) { pose.centre_m[1] = 0.5; }
void fill(body_modes& modes) {
    modes.count = 2;
    modes.swung[1] = 0.75F;
}
void fill(contact& touch) {
    touch.count = 2;
    touch.node = {3, 5};
    touch.force_n = {{1, 2, 3}, {4, 5, 6}};
}
void fill(servo_status& status) {
    status.count = 1;
    status.name = {"ticks"};
    status.value = {9};
}

/// A message of every channel, in the order of the list, and one of nobody's.
void write_log(const fs::path& file) {
    LogWriter log(file);
    std::int64_t utime = 0;
    each_channel([&]<typename Message>(const char* channel, std::size_t) {
        Message message{};
        message.utime = ++utime;
        fill(message);
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
        message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
        log.add(channel, bytes, utime);
    });
    const std::vector<std::uint8_t> other{'b', 'y', 't', 'e', 's'};
    log.add("OTHER", other, ++utime);
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
    // What pip installs of a page's program that hears a session.
    const Outcome imported =
        run(venv + "/bin/python -c 'from haptable.messages import contact, device_state, servo_force'", folder.path());
    EXPECT_EQ(imported.status, 0) << imported.err;

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

// setuptools keeps a list of files by their absolute paths. What make would build is nothing here.
TEST(PythonPackage, InstallsInAFolderThatWasCopiedAfterABuild) {
    if (!has_wheels()) GTEST_SKIP() << kNoWheels;
    const TemporaryFolder folder;
    fs::create_directories(folder.path() / "bin");
    write_file(folder.path() / "bin/make",
               "#!/bin/sh\nparts=build/package/python\nmkdir -p $parts/messages && touch $parts/messages/__init__.py\n"
               "echo 'int nothing;' | gcc -shared -fPIC -x c - -o $parts/libhaptable.so.1 && "
               "ln -sf libhaptable.so.1 $parts/libhaptable.so\n");
    fs::permissions(folder.path() / "bin/make", fs::perms::owner_all);
    const std::string at = folder.path().string();
    const Outcome made = run("mkdir " + at + "/first && tar cf - python setup.py pyproject.toml docs/PYTHON.md " +
                             "host/base/program.hpp host/library/haptable_library.h | tar xf - -C " + at +
                             "/first && python3 -m venv " + at + "/venv");
    ASSERT_EQ(made.status, 0) << made.err;
    const auto install = [&](const char* name) {
        return run("unset BUILD; PATH=" + at + "/bin:$PATH " + pip_of_wheels() + at +
                       "/venv/bin/pip install --quiet --no-deps --disable-pip-version-check .",
                   folder.path() / name);
    };
    Outcome installed = install("first");
    ASSERT_EQ(installed.status, 0) << installed.err;
    fs::copy(folder.path() / "first", folder.path() / "copy",
             fs::copy_options::recursive | fs::copy_options::copy_symlinks);
    installed = install("copy");
    EXPECT_EQ(installed.status, 0) << installed.err;
    fs::remove_all(folder.path() / "first");
    installed = install("copy");
    EXPECT_EQ(installed.status, 0) << installed.err;
}

}  // namespace
}  // namespace haptable::test
