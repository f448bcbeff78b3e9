// SPDX-License-Identifier: GPL-2.0-or-later
// Measured numbers between the markers of a page: each has one owner.
#include "host/report/page.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/report/numbers.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

nlohmann::ordered_json example() {
    Numbers numbers("make bench");
    numbers.add("worst", count(9275));
    numbers.add("steps", NumberTable{{"mode", "cube"},
                                     {{"nearest", seconds(6.21e-8)}, {"least", number(1.234e-3, "1.234 ms")}}});
    return numbers.json();
}

constexpr const char* kPage =
    "# A page\n\nAt the worst <!-- worst -->?<!-- /worst --> instructions.\n\n<!-- steps -->\nold\n<!-- /steps -->\n";
constexpr const char* kFilled =
    "# A page\n\nAt the worst <!-- worst -->9,275<!-- /worst --> instructions.\n\n<!-- steps -->\n| mode | cube |\n"
    "|---|---|\n| nearest | 62.1 ns |\n| least | 1.234 ms |\n<!-- /steps -->\n";

TEST(Page, IsFilledBetweenItsMarkersAndNowhereElse) {
    EXPECT_EQ(fill({"a.md", kPage}, example()), kFilled);
    EXPECT_EQ(fill({"a.md", kFilled}, example()), kFilled) << "twice is once";
    EXPECT_EQ(fill({"a.md", "<!-- a comment -->\n<!-- worst -->\n"}, example()),
              "<!-- a comment -->\n<!-- worst -->\n");
}

TEST(Page, AMarkerWithoutANumberIsAnErrorThatNamesPageAndMarker) {
    try {
        fill({"a.md", "<!-- speed -->x<!-- /speed -->"}, example());
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("a.md: the marker speed"), std::string::npos) << error.what();
    }
}

/// One fault, which has that part.
void expect_fault(const std::vector<Page>& pages, const std::string& part) {
    const auto faults = find_faults(pages, example());
    ASSERT_EQ(faults.size(), 1U) << (faults.empty() ? "" : faults[0]);
    EXPECT_NE(faults[0].find(part), std::string::npos) << faults[0];
}

TEST(Page, EveryNumberHasOneOwner) {
    EXPECT_TRUE(find_faults({{"a.md", kFilled}, {"b.md", "In 1234 and 62.1 and 150.\n"}}, example()).empty());
    expect_fault({{"a.md", kFilled + std::string("<!-- worst -->9,275<!-- /worst -->")}}, "worst stands in 2 places");
}

TEST(Page, FaultsAreTold) {
    std::string stale = kFilled;
    stale.replace(stale.find("9,275"), 5, "9,306");
    expect_fault({{"a.md", stale}}, "a.md: worst is not what numbers.json says");
    expect_fault({{"a.md", kFilled}, {"b.md", "It takes 9,275 instructions.\n"}}, "b.md: quotes 9275, of worst");
    expect_fault({{"a.md", kFilled}, {"b.md", "It takes 1.234 ms.\n"}}, "b.md: quotes 1.234, of steps");
    expect_fault({{"a.md", kFilled + std::string("<!-- speed -->x<!-- /speed -->")}}, "the marker speed has no number");
}

TEST(Numbers, GoThroughTheirFileAndReplaceTopicsByName) {
    const TemporaryFolder folder;
    Numbers numbers("make bench");
    numbers.add("steps", NumberTable{{"mode", "cube"}, {{"nearest", Number{{1.0, 2.0}, "1 / 2"}}}});
    numbers.write(folder.path() / "new/steps.json");
    auto topics = example();
    take(read_numbers(folder.path() / "new/steps.json"), topics);
    EXPECT_EQ(to_markdown(topics.at("steps")), "\n| mode | cube |\n|---|---|\n| nearest | 1 / 2 |\n");
    EXPECT_EQ(to_markdown(topics.at("worst")), "9,275");
    EXPECT_EQ(to_plot_data(topics.at("steps")), "\"nearest\" [1.0,2.0]\n");
    write_file(folder.path() / "all.json", to_text(topics));
    EXPECT_EQ(read_numbers(folder.path() / "all.json"), nlohmann::ordered_json::parse(to_text(topics)));
}

TEST(Numbers, ArePlottedByValueWithTheirTextsInQuotes) {
    Numbers numbers("make bench");
    numbers.add("points", NumberTable{{"body", "force", "time"}, {{"cube", "mask of 5 mm", seconds(2e-7)}}});
    EXPECT_EQ(to_plot_data(numbers.json().at("points")), "\"cube\" \"mask of 5 mm\" 2e-07\n");
}

TEST(Numbers, OneLineARunTellsWhatItMeasured) {
    auto topics = example();
    for (const char* name : {"worst", "steps"}) topics[name]["machine"] = "a processor";
    topics["strokes"] = {{"command", "make strokes"}, {"machine", "another"}, {"value", 1}, {"text", "1"}};
    EXPECT_EQ(runs(topics),
              "| command | machine | topics of docs/numbers.json |\n|---|---|---|\n"
              "| `make bench` | a processor | worst, steps |\n| `make strokes` | another | strokes |\n");
}

TEST(Numbers, AFileThatHoldsNoneIsAnErrorThatNamesIt) {
    const TemporaryFolder folder;
    for (const char* text : {"", "[]", "{\"a\": 1}", "{\"a\": {\"columns\": [\"x\"], \"rows\": [[\"1\", \"2\"]]}}",
                             "{\"a\": {\"value\": \"1\", \"text\": \"1\"}}"}) {
        write_file(folder.path() / "numbers.json", text);
        try {
            read_numbers(folder.path() / "numbers.json");
            ADD_FAILURE() << "no error: " << text;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("numbers.json"), std::string::npos) << error.what();
        }
    }
}

TEST(Numbers, AreRoundedAsPeopleReadThem) {
    EXPECT_EQ(count(999).text, "999");
    EXPECT_EQ(count(1234567).text, "1,234,567");
    EXPECT_EQ(seconds(6.21e-8).text, "62.1 ns");
    EXPECT_EQ(seconds(1.05e-2).text, "10.5 ms");
    EXPECT_EQ(seconds(42.0).text, "42 s");
    EXPECT_EQ(error_of(1.5e-7).text, "1.5e-07");
}

}  // namespace
}  // namespace haptable::test
