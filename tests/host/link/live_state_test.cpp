// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/live_state.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace haptable::test {
namespace {

TEST(LiveState, TellsAnEventOnceHoweverLongItGoesOn) {
    std::vector<std::string> told;
    LiveState live([&](const std::string& line) { told.push_back(line); });
    const Clock::time_point begin = Clock::now();
    const auto look = [&](int ms, std::int64_t value) {
        live.look("losses", value, begin + std::chrono::milliseconds(ms), [&] { return std::to_string(value); });
    };
    look(0, 0);
    EXPECT_TRUE(told.empty());
    for (int i = 1; i <= 30; ++i) look(100 * i, i);
    EXPECT_EQ(told, std::vector<std::string>{"1"});
    look(9000, 30);  // nothing since 3 s
    EXPECT_EQ(told.size(), 1U);
    look(9100, 31);
    EXPECT_EQ(told, (std::vector<std::string>{"1", "31"}));
    live.look("others", 1, begin + std::chrono::milliseconds(9100), [] { return "another counter"; });
    EXPECT_EQ(told.size(), 3U);
}

TEST(LiveState, IsStillWithoutAListener) {
    LiveState live(teller("servo", true));
    live.say("nothing");
    testing::internal::CaptureStderr();
    LiveState(teller("servo", false)).say("it begins");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "servo: it begins\n");
}

}  // namespace
}  // namespace haptable::test
