// SPDX-License-Identifier: GPL-2.0-or-later
// Two clocks: a steady one to wait and measure by, and the one that messages carry.
#pragma once

#include <chrono>
#include <cstdint>

namespace haptable {

/// CLOCK_MONOTONIC: for deadlines and latencies, never in a message.
using Clock = std::chrono::steady_clock;

/// The servo's tick: device states come once a millisecond.
inline constexpr std::chrono::microseconds kTick{1000};

/// Microseconds since the epoch, as the `utime` of messages.
inline std::int64_t utime_now() {
    const auto since_epoch = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::microseconds>(since_epoch).count();
}

/// A duration as microseconds with a fraction.
inline double to_us(Clock::duration duration) { return std::chrono::duration<double, std::micro>(duration).count(); }

}  // namespace haptable
