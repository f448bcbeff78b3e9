// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/child.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "host/base/shell.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLong{60'000};

bool is_alive(pid_t id) { return kill(id, 0) == 0; }

TEST(Child, HowItEndedIsShownWithItsLastWords) {
    for (const auto& [script, said] : {std::pair("echo first >&2; echo 'servo: no tables' >&2; exit 3",
                                                 "servo ended with status 3: servo: no tables"),
                                       {"kill -9 $$", "servo was ended by signal 9 (Killed)"}}) {
        Child child("servo", {"sh", "-c", script});
        child.wait(kLong);
        EXPECT_FALSE(child.is_well());
        EXPECT_EQ(child.how_it_ended(), said);
    }
    Child missing("viewer", {"/nonexistent/haptable-view"});
    missing.wait(kLong);
    EXPECT_FALSE(missing.is_well());
    EXPECT_TRUE(says(missing.how_it_ended(), "/nonexistent/haptable-view"));
}

// Nor are its last words the reason: they were of something else.
TEST(Child, ASignalFromOutsideHasNoLastWords) {
    for (const char* signal : {"9", "15", "6"}) {
        Child child("servo", {"sh", "-c", std::string("echo 'servo: hears' >&2; kill -") + signal + " $$"});
        child.wait(kLong);
        EXPECT_EQ(child.last_words(), "servo: hears");
        EXPECT_EQ(child.how_it_ended().find("servo: hears") != std::string::npos, signal[0] == '6') << signal;
    }
}

TEST(Child, TellsEachLineOnce) {
    Child child("servo", {"sh", "-c", "printf 'first\\nsecond\\nhal' >&2; read wait"});
    std::vector<std::string> lines;
    while (lines.size() < 2 && !child.has_ended()) {
        child.wait_some(kLong);
        for (std::string& line : child.new_lines()) lines.push_back(std::move(line));
    }
    child.wait(kLong);
    EXPECT_EQ(lines, (std::vector<std::string>{"first", "second"}));
    EXPECT_TRUE(child.new_lines().empty());
}

TEST(Child, EndsWhenAskedAndItsOutputIsKept) {
    Child child("sleep", {"sh", "-c",
                          "trap 'echo bye; exit 0' TERM; echo a complaint >&2; echo ready; "
                          "while :; do sleep 0.01; done"});
    while (child.out() != "ready\n" && !child.has_ended()) child.wait_some(kLong);
    child.ask_to_end();
    child.wait(kLong);
    EXPECT_TRUE(child.has_ended());
    EXPECT_TRUE(child.is_well());
    EXPECT_EQ(child.out(), "ready\nbye\n");
}

TEST(Child, IsKilledWhereItDoesNotEnd) {
    Child child("deaf", {"sh", "-c", "trap '' TERM; echo ready; while :; do sleep 0.01; done"});
    while (child.out().empty() && !child.has_ended()) child.wait_some(kLong);
    child.ask_to_end();
    child.wait(milliseconds(50));
    EXPECT_TRUE(child.has_ended());
    EXPECT_EQ(child.how_it_ended(), "deaf was ended by signal 9 (Killed), as it did not end by itself");
}

/// The number that a child prints first.
pid_t id_printed_by(Child& child) {
    while (child.out().find('\n') == std::string::npos && !child.has_ended()) child.wait_some(kLong);
    return child.out().empty() ? 0 : std::stoi(child.out());
}

TEST(Child, DoesNotOutliveItsObject) {
    pid_t id = 0;
    {
        Child child("sleep", {"sh", "-c", "echo $$; exec sleep 60"});
        id = id_printed_by(child);
        ASSERT_GT(id, 0);
        ASSERT_TRUE(is_alive(id));
    }
    EXPECT_FALSE(is_alive(id));  // nor is it a zombie, which would be alive
}

// Where the parent itself is killed, the kernel ends its children.
TEST(Child, DoesNotOutliveAKilledParent) {
    const TemporaryFolder folder;
    const std::string file = (folder.path() / "id").string();
    status_of([&] {
        Child child("sleep", {"sh", "-c", "echo $$; exec sleep 60"});
        std::ofstream(file) << id_printed_by(child) << std::endl;
        return kill(getpid(), SIGKILL);
    });
    pid_t id = 0;
    std::ifstream(file) >> id;
    ASSERT_GT(id, 0);
    const auto is_running = [id] {  // a zombie that nobody reaps in this namespace has ended, too
        std::ifstream stat("/proc/" + std::to_string(id) + "/stat");
        std::string word, state;
        return stat >> word >> word >> state && state != "Z";
    };
    for (int tries = 0; tries < 1000 && is_running(); ++tries) std::this_thread::sleep_for(milliseconds(10));
    EXPECT_FALSE(is_running());
}

TEST(ShellQuoted, IsOneWordOfAShell) {
    for (const std::string name : {"$(touch pwned)", "`touch pwned`", "'; touch pwned; echo '", "\";touch pwned;\"",
                                   "a\ntouch pwned\n", "\\'; touch pwned; \\'", "a\\", "'", "''", "*", "~", "a b  c"})
        EXPECT_EQ(run("printf '%s|' " + shell_quoted(name)).out, name + "|");
    EXPECT_EQ(no_option("-x"), "./-x");
}

}  // namespace
}  // namespace haptable::test
