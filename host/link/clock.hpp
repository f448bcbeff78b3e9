// SPDX-License-Identifier: GPL-2.0-or-later
// Two clocks: a steady one to wait and measure by, and the one that messages carry. Both can be simulated.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <utility>

namespace haptable {

class SimulatedTime;

/// CLOCK_MONOTONIC: for deadlines and latencies, never in a message.
class Clock {
public:
    using duration = std::chrono::steady_clock::duration;
    using time_point = std::chrono::steady_clock::time_point;

    static time_point now();
    /// Where time is simulated; else null.
    static SimulatedTime* simulated() { return simulated_; }

private:
    friend class SimulatedTime;
    inline static SimulatedTime* simulated_ = nullptr;
};

/// While it lives, time stands still in this process while programs work, and leaps where they would wait: a session
/// over memq:// keeps its clocks, watchdogs and ages, and an hour of it takes a minute. For one thread.
class SimulatedTime {
public:
    SimulatedTime() { Clock::simulated_ = this; }
    ~SimulatedTime() { Clock::simulated_ = nullptr; }
    SimulatedTime(const SimulatedTime&) = delete;
    SimulatedTime& operator=(const SimulatedTime&) = delete;

    Clock::time_point now() const { return now_; }
    /// Who else waits: `next` says until when, `work` is called then, as its own loop would.
    void also(std::function<Clock::time_point()> next, std::function<void(Clock::time_point)> work) {
        next_ = std::move(next);
        work_ = std::move(work);
    }
    /// To the deadline, or to the other's next work, which is done, where that is earlier.
    void leap(Clock::time_point deadline) {
        const Clock::time_point next = next_ ? next_() : Clock::time_point::max();
        if (next > deadline) {
            now_ = std::max(now_, deadline);
            return;
        }
        now_ = std::max(now_, next);
        work_(now_);
    }

private:
    // Later than the epoch by some days, as a machine's is: no difference of two times meets 0.
    Clock::time_point now_{std::chrono::hours(100)};
    std::function<Clock::time_point()> next_;
    std::function<void(Clock::time_point)> work_;
};

inline Clock::time_point Clock::now() {
    return simulated_ != nullptr ? simulated_->now() : std::chrono::steady_clock::now();
}

/// The servo's tick: device states come once a millisecond.
inline constexpr std::chrono::microseconds kTick{1000};

/// Microseconds since the epoch, as the `utime` of messages.
inline std::int64_t utime_now() {
    using std::chrono::duration_cast, std::chrono::microseconds;
    if (const SimulatedTime* simulated = Clock::simulated())
        return duration_cast<microseconds>(simulated->now().time_since_epoch()).count();
    return duration_cast<microseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// A duration as microseconds with a fraction.
inline double to_us(Clock::duration duration) { return std::chrono::duration<double, std::micro>(duration).count(); }

}  // namespace haptable
