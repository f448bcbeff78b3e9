// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

// Against sorting: the quantile is the exact one, or up to 1 % above it.
TEST(DurationStatistics, AgreesWithSortedValues) {
    std::mt19937 random(3);
    std::lognormal_distribution<double> latency_us(4.0, 1.5);
    std::vector<double> values;
    DurationStatistics statistics;
    double sum = 0.0;
    for (int i = 0; i < 20000; ++i) {
        values.push_back(latency_us(random));
        statistics.add(values.back());
        sum += values.back();
    }
    std::sort(values.begin(), values.end());
    EXPECT_EQ(statistics.count(), values.size());
    EXPECT_EQ(statistics.mean_us(), sum / 20000.0);
    EXPECT_EQ(statistics.max_us(), values.back());
    for (const double share : {0.001, 0.5, 0.9, 0.999, 1.0}) {
        const double exact = values[static_cast<std::size_t>(std::ceil(share * 20000.0)) - 1];
        // The limits of a bucket are powers, whose logarithms round: 20 of them are a power of 1.22.
        const Bound rounded{.count = 1000, .size = exact};
        EXPECT_WITHIN(exact - statistics.quantile_us(share), rounded) << share;
        EXPECT_WITHIN(statistics.quantile_us(share) - 1.01 * exact, rounded) << share;
    }
}

TEST(DurationStatistics, IsZeroWithoutValues) {
    const DurationStatistics none;
    EXPECT_EQ(none.mean_us(), 0.0);
    EXPECT_EQ(none.quantile_us(0.999), 0.0);
    EXPECT_EQ(none.max_us(), 0.0);
}

TEST(DurationStatistics, TakesValuesBeyondItsRange) {
    DurationStatistics statistics;
    for (const double us : {-5.0, 0.0, 1e-9, 1e12}) statistics.add(us);
    EXPECT_EQ(statistics.max_us(), 1e12);
    EXPECT_EQ(statistics.quantile_us(0.5), 0.01);
}

TEST(SequenceGaps, CountsWhatIsMissing) {
    SequenceGaps gaps;
    for (const std::int64_t seq : {7, 8, 8}) gaps.note(seq);  // may begin anywhere
    EXPECT_EQ(gaps.lost(), 0);
    gaps.note(12);
    EXPECT_EQ(gaps.lost(), 3);
    for (const std::int64_t seq : {0, 1}) gaps.note(seq);
    EXPECT_EQ(gaps.lost(), 3);
    gaps.begin();
    gaps.note(9);
    EXPECT_EQ(gaps.lost(), 3);
}

// A number that no sender reaches is a number like any other.
TEST(SequenceGaps, TakesEveryNumber) {
    constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
    SequenceGaps gaps;
    for (const std::int64_t seq : {-kMost - 1, kMost, kMost, std::int64_t{0}, kMost}) gaps.note(seq);
    EXPECT_EQ(gaps.lost(), kMost);
}

}  // namespace
}  // namespace haptable::test
