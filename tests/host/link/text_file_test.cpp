// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/text_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

TEST(TextFile, IsThereWhenItIsWhole) {
    const WorkFolder folder;
    TextFile file(folder / "a.csv");
    file.add("one\n");
    file.flush();
    EXPECT_FALSE(std::filesystem::exists(folder / "a.csv"));
    file.finish();
    EXPECT_EQ(read_file(folder / "a.csv"), "one\n");
}

// Whatever ends the session: what was added is there.
TEST(TextFile, KeptItSurvivesAnException) {
    const WorkFolder folder;
    error_of([&] {
        TextFile file(folder / "a.csv");
        file.add("header\n");
        file.keep();
        file.add("one\n");
        throw Error("the cable was pulled out");
    });
    EXPECT_EQ(read_file(folder / "a.csv"), "header\none\n");
    EXPECT_EQ(folder.file_count(), 1U);
}

TEST(TextFile, KeptItSurvivesAKilledProcess) {
    const WorkFolder folder;
    const int status = status_of([&] {
        TextFile file(folder / "a.csv");
        file.add("header\n");
        file.keep();
        file.add("one\n");
        file.flush();
        file.add("two\n");
        return kill(getpid(), SIGKILL);
    });
    EXPECT_EQ(status, -SIGKILL);
    EXPECT_EQ(read_file(folder / "a.csv"), "header\none\n");
}

// A disk that takes half a line: whole lines are kept, and the end is an error that names the file.
TEST(TextFile, KeepsWholeLinesOnAFullDisk) {
    const WorkFolder folder;
    const int status = status_of([&] {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit most{10, 10};
        setrlimit(RLIMIT_FSIZE, &most);
        const auto write = [&] {
            TextFile file(folder / "a.csv");
            file.add("header\n");
            file.keep();
            for (int line = 0; line < 3; ++line) {
                file.add("one\n");
                file.flush();
            }
            file.finish();
        };
        return fails_with(write, "a.csv: cannot be written") ? 0 : 1;
    });
    EXPECT_EQ(status, 0);
    EXPECT_EQ(read_file(folder / "a.csv"), "header\n");
}

}  // namespace
}  // namespace haptable::test
