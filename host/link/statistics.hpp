// SPDX-License-Identifier: GPL-2.0-or-later
// Mean, quantiles and maximum of a stream of durations in fixed memory, and the gaps of a numbered stream.
#pragma once

#include <array>
#include <cstdint>

namespace haptable {

/// Durations in microseconds. Mean and maximum are exact; a quantile is read from a histogram whose buckets grow by
/// 1 %, so it is at most 1 % too large. No allocation, and the same cost for the first and the billionth value.
class DurationStatistics {
public:
    void add(double us);

    std::uint64_t count() const { return count_; }
    double mean_us() const { return count_ == 0 ? 0.0 : sum_us_ / static_cast<double>(count_); }
    double max_us() const { return max_us_; }
    /// The smallest bucket edge that at least `share` of the values do not exceed: 0.999 for the 99.9 % value.
    double quantile_us(double share) const;

private:
    // From 10 ns (ratio 1.01 a bucket) to 10 ns * 1.01^2100 = 12 s; what is longer counts in the last bucket.
    static constexpr int kBuckets = 2100;

    std::array<std::uint64_t, kBuckets> bucket_{};
    std::uint64_t count_ = 0;
    double sum_us_ = 0.0;
    double max_us_ = 0.0;
};

/// Counts the messages that are missing from a stream numbered 0, 1, 2, ...
class SequenceGaps {
public:
    /// The stream may begin anywhere. A smaller number than the last one is a sender that has begun anew.
    void note(std::int64_t seq);
    /// The next number may be any: it belongs to another stream.
    void begin() { begun_ = false; }
    /// Stops at the largest int64.
    std::int64_t lost() const { return lost_; }

private:
    bool begun_ = false;
    std::int64_t last_ = 0;
    std::int64_t lost_ = 0;
};

}  // namespace haptable
