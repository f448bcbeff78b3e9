// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/program.hpp"

#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"

namespace haptable {
namespace {

using test::Outcome;

Outcome run_with(std::vector<std::string> arguments, const std::function<void()>& work) {
    CommandLine app("A program.", "prog");
    std::vector<char*> argv;
    arguments.insert(arguments.begin(), "prog");
    for (std::string& argument : arguments) argv.push_back(argument.data());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Outcome run;
    run.status = run_program(app, int(argv.size()), argv.data(), work);
    run.out = testing::internal::GetCapturedStdout();
    run.err = testing::internal::GetCapturedStderr();
    return run;
}

TEST(Program, SucceedsInSilence) {
    const Outcome run = run_with({}, [] {});
    EXPECT_EQ(run.status, 0);
    EXPECT_EQ(run.out + run.err, "");
}

TEST(Program, AnErrorIsOneLineOnStandardError) {
    const Outcome run = run_with({}, [] { throw Error("a.toml:3: wrong\nbecause\n"); });
    EXPECT_EQ(run.status, 1);
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(run.err, "prog: a.toml:3: wrong because\n");
}

TEST(Program, EveryExceptionIsCaught) {
    EXPECT_EQ(run_with({}, [] { throw std::bad_alloc(); }).status, 1);
    EXPECT_EQ(run_with({}, [] { throw std::logic_error("x"); }).err, "prog: x\n");
    EXPECT_EQ(run_with({}, [] { throw Interrupted(); }).status, 130);
}

TEST(Program, AnUnknownOptionIsAnErrorAndDoesNoWork) {
    const Outcome run = run_with({"--no-such-option"}, [] { FAIL(); });
    EXPECT_EQ(run.status, 2);
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

TEST(Program, ANumberOfTheCommandLineIsFiniteAndAsItsOptionSays) {
    struct Row {
        std::string option, value, what;
    };
    for (const auto& [option, value, what] : {Row{"--any", "nan", "nan must be a finite number"},
                                              {"--any", "-inf", "-inf must be a finite number"},
                                              {"--range", "nan", "nan must be a finite number"},
                                              {"--list", "1,1e999", "1e999 must be a finite number"},
                                              {"--place", "1,nan", "nan must be a finite number"},
                                              {"--above", "0", "0 must be above 0"},
                                              {"--from", "-1", "-1 must be 0 or more"}}) {
        CommandLine app("A program.", "prog");
        double number = 0.0;
        std::vector<double> list;
        app.option("--any", number, "");
        app.option("--range", number, "").range(0.0, 1.0);
        app.option("--above", number, "").positive();
        app.option("--from", number, "").non_negative();
        app.option("--list", list, "").delimiter(',');
        app.numbers(
               "--place", [](const std::vector<double>&) {}, "")
            .delimiter(',');
        std::string given[] = {"prog", option, value};
        char* argv[] = {given[0].data(), given[1].data(), given[2].data()};
        EXPECT_EQ(test::error_of([&] { app.parse(3, argv); }), option + ": " + what + " (see --help)");
    }
}

TEST(Program, HelpAndVersionGoToStandardOutput) {
    const Outcome help = run_with({"--help"}, [] { FAIL(); });
    EXPECT_EQ(help.status, 0);
    EXPECT_TRUE(test::says(help.out, "A program."));
    const Outcome version = run_with({"--version"}, [] { FAIL(); });
    EXPECT_EQ(version.status, 0);
    EXPECT_EQ(version.out, std::string("prog ") + kVersion + "\n");
}

}  // namespace
}  // namespace haptable
