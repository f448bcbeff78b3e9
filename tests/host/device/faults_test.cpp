// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/faults.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>

#include "host/device/faulty_lane.hpp"
#include "tests/error_of.hpp"

namespace haptable::test {
namespace {

std::string complaint_about(const std::string& text) {
    return error_of([&] { parse_faults(text); });
}

TEST(FaultPlans, AreReadWithTheirUnits) {
    const FaultPlan plan = parse_faults("drop=0.01,delay=20ms,jitter=500us,stuck=0.001,jump=0.002:3mm,gone=1e-4:0.3s");
    EXPECT_EQ(plan.drop, 0.01);
    EXPECT_DOUBLE_EQ(plan.delay_s, 0.02);
    EXPECT_DOUBLE_EQ(plan.jitter_s, 5e-4);
    EXPECT_EQ(plan.stuck.share, 0.001);
    EXPECT_EQ(plan.stuck.size, 0.05);
    EXPECT_DOUBLE_EQ(plan.jump.size, 0.003);
    EXPECT_EQ(plan.gone.share, 1e-4);
    EXPECT_EQ(plan.gone.size, 0.3);
    EXPECT_EQ(plan.nan, 0.0);
}

TEST(FaultPlans, ComplaintsNameThePartAndWhatMayStandThere) {
    EXPECT_EQ(complaint_about("drop=0.01,delay=20"), "--fault: \"delay=20\": give a time with s, ms or us, as in 20ms");
    EXPECT_EQ(complaint_about("drop=1.5"), "--fault: \"drop=1.5\": give a share from 0 to 1, as in 0.01");
    EXPECT_EQ(complaint_about("drop"), "--fault: \"drop\": give what it is, as in drop=0.01 or delay=20ms");
    EXPECT_EQ(complaint_about("jump=0.1:5ms"), "--fault: \"jump=0.1:5ms\": give a length with m, mm or um, as in 25mm");
    EXPECT_TRUE(says(complaint_about("loss=0.1"), "there are drop, double, reorder, corrupt, delay"));
    for (const char* bad : {"", "drop=", "drop=nan", "delay=-1ms", "delay=1e999s", "drop=0.1,", "stuck=0.1:"})
        EXPECT_NE(complaint_about(bad), "no error") << bad;
}

TEST(FaultPlans, AsTextAreReadBack) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        const std::string text = to_text(random_faults(seed));
        EXPECT_TRUE(text.empty() || to_text(parse_faults(text)) == text) << text;
    }
    EXPECT_FALSE(FaultPlan{}.any());
}

TEST(DeviceFaults, StuckEncodersKeepTheirReading) {
    DeviceFaults faults(parse_faults("stuck=1:10ms"), 1);
    const Clock::time_point begin{};
    for (int ms = 0; ms < 10; ++ms)
        EXPECT_EQ(faults.see({1.0 + ms, 0.0, 0.0}, begin + std::chrono::milliseconds(ms)).x(), 1.0) << ms;
    EXPECT_EQ(faults.see({20.0, 0.0, 0.0}, begin + std::chrono::milliseconds(10)).x(), 20.0);
}

TEST(DeviceFaults, AJumpIsAsLongAsAskedForAndOver) {
    DeviceFaults faults(parse_faults("jump=0.5:25mm"), 1);
    int jumps = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const double off_m = faults.see(Eigen::Vector3d::Zero(), Clock::time_point{}).norm();
        if (off_m > 0.0) ++jumps;
        EXPECT_TRUE(off_m <= 0.0 || std::abs(off_m - 0.025) < 1e-15) << off_m;
    }
    EXPECT_NEAR(jumps, 500, 5.0 * std::sqrt(250.0));
}

/// Numbered messages of four bytes through a lane, one a millisecond: what came out, and when.
std::vector<std::pair<std::int64_t, std::uint32_t>> through(const std::string& faults, std::uint32_t count) {
    FaultyLane lane(parse_faults(faults), 1);
    std::vector<std::pair<std::int64_t, std::uint32_t>> out;
    const Clock::time_point begin{};
    for (std::uint32_t ms = 0; ms < count + 100; ++ms) {
        const Clock::time_point now = begin + std::chrono::milliseconds(ms);
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(&ms);
        if (ms < count) lane.put({bytes, sizeof ms}, now);
        lane.deliver(now, [&](std::span<const std::uint8_t> message) {
            std::uint32_t number = 0;
            std::copy(message.begin(), message.end(), reinterpret_cast<std::uint8_t*>(&number));
            out.emplace_back(ms, number);
        });
    }
    return out;
}

TEST(FaultyLane, ReordersWhatItHoldsBack) {
    const auto out = through("reorder=0.2", 1000);
    ASSERT_EQ(out.size(), 1000U);
    int overtaken = 0;
    for (std::size_t i = 1; i < out.size(); ++i) overtaken += out[i].second < out[i - 1].second ? 1 : 0;
    // Held back, and the next one not: 0.2 * 0.8.
    EXPECT_NEAR(overtaken, 160, 5.0 * std::sqrt(1000.0 * 0.16 * 0.84));
}

TEST(FaultyLane, DamagesOneToThreeBits) {
    int damaged = 0;
    for (const auto& [ms, number] : through("corrupt=1", 1000)) {
        const int bits = std::popcount(number ^ static_cast<std::uint32_t>(ms));
        EXPECT_LE(bits, 3);
        damaged += bits > 0 ? 1 : 0;
    }
    EXPECT_GT(damaged, 900);
}

// Of what is on its way it keeps so much and no more.
TEST(FaultyLane, HoldsAsManyAsItHasRoomFor) {
    EXPECT_EQ(through("delay=90ms", 90).size(), 90U);
    FaultyLane lane(parse_faults("delay=1s"), 1);
    const std::array<std::uint8_t, 4> bytes{};
    for (std::size_t i = 0; i < 2 * FaultyLane::kSlots; ++i) lane.put(bytes, Clock::time_point{});
    std::size_t came = 0;
    lane.deliver(Clock::time_point::max(), [&](std::span<const std::uint8_t>) { ++came; });
    EXPECT_EQ(came, FaultyLane::kSlots);
}

}  // namespace
}  // namespace haptable::test
