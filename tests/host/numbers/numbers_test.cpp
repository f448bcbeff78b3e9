// SPDX-License-Identifier: GPL-2.0-or-later
// Measured numbers as programs write them; tests/lab/test_numbers.py has their way into the pages.
#include "host/numbers/numbers.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

TEST(Numbers, GoThroughTheirFile) {
    const TemporaryFolder folder;
    Numbers numbers("make bench");
    numbers.add("worst", count(9275));
    numbers.add("steps", NumberTable{{"mode", "cube"}, {{"nearest", Number{{1.0, 2.0}, "1 / 2"}}}});
    numbers.write(folder.path() / "new/steps.json");
    const auto topics = read_numbers(folder.path() / "new/steps.json");
    EXPECT_EQ(topics.at("worst").at("command"), "make bench");
    EXPECT_EQ(to_markdown(topics.at("steps")), "\n| mode | cube |\n|---|---|\n| nearest | 1 / 2 |\n");
    EXPECT_EQ(to_markdown(topics.at("worst")), "9,275");
}

TEST(Numbers, AFileThatHoldsNoneIsAnErrorThatNamesIt) {
    const TemporaryFolder folder;
    for (const char* text : {"", "[]", "{\"a\": 1}", "{\"a\": {\"columns\": [\"x\"], \"rows\": [[\"1\", \"2\"]]}}",
                             "{\"a\": {\"value\": \"1\", \"text\": \"1\"}}"}) {
        write_file(folder.path() / "numbers.json", text);
        const std::string said = error_of([&] { read_numbers(folder.path() / "numbers.json"); });
        EXPECT_NE(said.find("numbers.json"), std::string::npos) << said;
    }
}

TEST(Numbers, AreRoundedAsPeopleReadThem) {
    EXPECT_EQ(count(999).text, "999");
    EXPECT_EQ(count(1234567).text, "1,234,567");
    EXPECT_EQ(seconds(6.21e-8).text, "62.1 ns");
    EXPECT_EQ(seconds(1.05e-2).text, "10.5 ms");
    EXPECT_EQ(seconds(42.0).text, "42 s");
    EXPECT_EQ(haptable::error_of(1.5e-7).text, "1.5e-07");
}

}  // namespace
}  // namespace haptable::test
