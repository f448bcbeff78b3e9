// SPDX-License-Identifier: GPL-2.0-or-later
// What keeps a servo's force in bounds beside max_force: of a scene, and of the tables that are made from it.
#pragma once

#include <numbers>
#include <string>

namespace haptable {

inline constexpr double kServoTick_s = 0.001;  ///< HAPTABLE_TICK_US of the firmware

/// 0: without that limit, and without a byte of it in the firmware (docs/SAFETY.md).
struct SafetyLimits {
    double max_speed_m_s = 0.0;           ///< of a finger: faster, and a position is not believed
    double max_force_rate_n_per_s = 0.0;  ///< by which the force rises
    double mean_force_n = 0.0;            ///< root of the mean of the squared force
    double mean_force_time_s = 30.0;      ///< of the filter of first order that takes that mean
    double ramp_s = 0.0;  ///< in which a force comes back inside the body; 0: after the finger has left it
    bool grab = false;    ///< a button holds the contact
    bool check = false;   ///< of the tables' CRC, before the first force and again

    /// A mean that is larger than the largest force cannot be.
    bool has_mean(double max_force_n) const { return mean_force_n > 0.0 && mean_force_n < max_force_n; }

    bool operator==(const SafetyLimits&) const = default;
};

/// The hand's limits as they are at the body: motion_scale is the body's motion over the hand's, force_scale the hand's
/// force over the body's.
inline SafetyLimits at_body(SafetyLimits hand, double motion_scale, double force_scale) {
    hand.max_speed_m_s *= motion_scale;
    hand.max_force_rate_n_per_s /= force_scale;
    hand.mean_force_n /= force_scale;
    return hand;
}

/// What is wrong with mean_force_time beside these forces; empty: nothing.
std::string fault_of_mean(const SafetyLimits& limits, double max_force_n);

/// Time of a force on its way to the motors and behind their lag of first order, s.
inline double whole_delay_s(double delay_s, double bandwidth_hz) {
    return delay_s + (bandwidth_hz > 0.0 ? 1.0 / (2.0 * std::numbers::pi * bandwidth_hz) : 0.0);
}

}  // namespace haptable
