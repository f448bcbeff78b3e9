// SPDX-License-Identifier: GPL-2.0-or-later
// A device's limits and delay as the servo meets them.
#pragma once

#include <numbers>

#include "host/base/limits.hpp"

namespace haptable {

/// The hand's limits as they are at the body: motion_scale is the body's motion over the hand's, force_scale the hand's
/// force over the body's.
inline SafetyLimits at_body(SafetyLimits hand, double motion_scale, double force_scale) {
    hand.max_speed_m_s *= motion_scale;
    hand.max_force_rate_n_per_s /= force_scale;
    hand.mean_force_n /= force_scale;
    return hand;
}

/// Time of a force on its way to the motors and behind their lag of first order, s.
inline double whole_delay_s(double delay_s, double bandwidth_hz) {
    return delay_s + (bandwidth_hz > 0.0 ? 1.0 / (2.0 * std::numbers::pi * bandwidth_hz) : 0.0);
}

}  // namespace haptable
