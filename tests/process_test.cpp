// SPDX-License-Identifier: GPL-2.0-or-later
// The helper that other tests count on: what a program says, how it ends, and that one that hangs is a failure.
#include "tests/process.hpp"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <csignal>

namespace haptable::test {
namespace {

TEST(Process, TellsOutputStatusAndSignal) {
    const Outcome outcome = run("echo out; echo err >&2; exit 3");
    EXPECT_EQ(outcome.status, 3);
    EXPECT_EQ(outcome.out, "out\n");
    EXPECT_EQ(outcome.err, "err\n");
    EXPECT_EQ(run("pwd", "/").out, "/\n");
    EXPECT_EQ(run("kill -9 $$").status, -SIGKILL);
    EXPECT_THROW(Process({"haptable-no-such-program"}), std::runtime_error);
}

TEST(Process, AProgramThatHangsFailsTheTestAndEndsWithAllThatItStarted) {
    Outcome outcome;
    EXPECT_NONFATAL_FAILURE(outcome = run("sleep 60 & echo $!; sleep 60", {}, std::chrono::seconds(1)), "killed");
    EXPECT_EQ(outcome.status, -SIGKILL);
    // Its child is gone too, or a zombie that nobody has asked for.
    const std::string pid = outcome.out.substr(0, outcome.out.find('\n'));
    const std::string gone =
        "while read -r _ _ state _ </proc/" + pid + "/stat && [ $state != Z ]; do sleep 0.01; done";
    run(gone, {}, std::chrono::seconds(10));
}

}  // namespace
}  // namespace haptable::test
