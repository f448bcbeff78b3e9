// SPDX-License-Identifier: GPL-2.0-or-later
// What can go wrong between a finger and its servo, on purpose: which faults, how often, and the dice.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "host/link/clock.hpp"

namespace haptable {

/// A fault that begins in a tick with this probability and lasts so long, or is so large.
struct Spell {
    double share = 0.0;
    double size = 0.0;  ///< s, or m
};

struct FaultPlan {
    // Messages, both ways; shares of them.
    double drop = 0.0;      ///< never arrive
    double twice = 0.0;     ///< arrive twice
    double reorder = 0.0;   ///< arrive behind the one that follows
    double corrupt = 0.0;   ///< arrive with one to three bits turned
    double delay_s = 0.0;   ///< all arrive so much later
    double jitter_s = 0.0;  ///< and later by up to so much more
    // The device.
    Spell gone;        ///< it neither sends nor hears anything for so long
    Spell stuck;       ///< its encoders keep their reading
    Spell jump;        ///< one reading is so far off
    double nan = 0.0;  ///< share of readings that are no number
    Spell clock_back;  ///< its clock is set back by so much

    bool any() const;
};

/// "drop=0.01,delay=20ms,stuck=0.001:50ms": NAME=SHARE, NAME=TIME, or NAME=SHARE:SIZE with s, ms, us, m or mm. A size
/// that is left out is 50 ms, or 25 mm for a jump. Throws Error that names the part and says what may stand there.
FaultPlan parse_faults(const std::string& text);

/// A mixture of faults by lot, each there or not, from hardly ever to often: the same for the same seed, everywhere.
FaultPlan random_faults(std::uint64_t seed);
/// As parse_faults reads it.
std::string to_text(const FaultPlan& plan);

/// Random numbers that are the same with every standard library.
class Dice {
public:
    explicit Dice(std::uint64_t seed) : random_(seed) {}
    /// In [0, 1).
    double uniform() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
    bool hits(double share) { return share > 0.0 && uniform() < share; }
    std::size_t below(std::size_t count) { return static_cast<std::size_t>(uniform() * static_cast<double>(count)); }

private:
    std::mt19937_64 random_;
};

inline Clock::duration in_seconds(double s) { return std::chrono::nanoseconds(std::llround(1e9 * s)); }

/// Faults of encoders, clock and plug. Each is asked once a tick.
class DeviceFaults {
public:
    DeviceFaults(const FaultPlan& plan, std::uint64_t seed) : plan_(plan), dice_(seed) {}
    /// What the device reads at a tick instead of its position.
    Eigen::Vector3d see(const Eigen::Vector3d& position_m, Clock::time_point now);
    /// True while it is gone.
    bool is_gone(Clock::time_point now);
    /// What its clock says instead of the time.
    std::int64_t clock(std::int64_t utime);

private:
    FaultPlan plan_;
    Dice dice_;
    Eigen::Vector3d stuck_at_m_ = Eigen::Vector3d::Zero();
    Clock::time_point stuck_until_{}, gone_until_{};
    std::int64_t back_us_ = 0;
};

}  // namespace haptable
