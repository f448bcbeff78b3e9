// SPDX-License-Identifier: GPL-2.0-or-later
// bucket(t) = ceil(log(t / t0) / log(1.01)): a histogram of constant relative resolution.
#include "host/link/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptable {

namespace {

constexpr double kSmallest_us = 0.01;
constexpr double kRatio = 1.01;

}  // namespace

void DurationStatistics::add(double us) {
    ++count_;
    sum_us_ += us;
    max_us_ = std::max(max_us_, us);
    // max() also keeps zero and negative durations (a clock set back) out of the logarithm.
    const double bucket = std::ceil(std::log(std::max(us, kSmallest_us) / kSmallest_us) / std::log(kRatio));
    ++bucket_[static_cast<std::size_t>(std::min(bucket, kBuckets - 1.0))];
}

double DurationStatistics::quantile_us(double share) const {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
    std::uint64_t seen = 0;
    for (int i = 0; i < kBuckets; ++i) {
        seen += bucket_[static_cast<std::size_t>(i)];
        if (seen >= wanted && seen > 0) return std::min(kSmallest_us * std::pow(kRatio, i), max_us_);
    }
    return max_us_;
}

void SequenceGaps::note(std::int64_t seq) {
    if (begun_ && seq > last_) {
        // The distance of any two numbers fits 64 bits without a sign.
        const std::uint64_t missing = static_cast<std::uint64_t>(seq) - static_cast<std::uint64_t>(last_) - 1;
        const auto room = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max() - lost_);
        lost_ += static_cast<std::int64_t>(std::min(missing, room));
    }
    begun_ = true;
    last_ = seq;
}

}  // namespace haptable
