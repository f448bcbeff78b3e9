// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/ringing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/device/driver.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

constexpr int kTicks = 4000;  // most cycles grow or end within a second
constexpr double kGrown = 1.5, kGone = 0.5;

}  // namespace

bool rings(const RingingLoop& loop, double stiffness_n_per_m) {
    Device device = loop.device;
    device.unbalanced = 0.0;  // only moves the middle
    device.reach_m = {0.0, 0.0, 0.0};
    // At rest where an undamped oscillation of this speed turns.
    const double all_n_per_m = stiffness_n_per_m + loop.hand.stiffness_n_per_m;
    PointDevice point(device, loop.hand, {loop.speed_m_s * std::sqrt(device.mass_kg[0] / all_n_per_m), 0.0, 0.0});
    const HandGoal middle{Vector3d::Zero(), Vector3d::Zero()};
    double peak_m_s = 0.0, last_peak_m_s = loop.speed_m_s;
    for (int tick = 0; tick < kTicks; ++tick) {
        point.set_force(-stiffness_n_per_m * point.encoder_m());
        const bool was_right = point.position_m().x() > 0.0;
        for (int i = 0; i < kDeviceSubsteps; ++i) {
            point.advance(middle, kDeviceTick_s / kDeviceSubsteps);
            peak_m_s = std::max(peak_m_s, std::abs(point.velocity_m_s().x()));
        }
        if (peak_m_s > kGrown * loop.speed_m_s) return true;
        if (was_right == (point.position_m().x() > 0.0)) continue;
        // Half a cycle more.
        last_peak_m_s = std::exchange(peak_m_s, 0.0);
        if (last_peak_m_s < kGone * loop.speed_m_s) return false;
    }
    return last_peak_m_s > loop.speed_m_s;
}

double ringing_stiffness(const RingingLoop& loop) {
    constexpr double kSoftest = 1.0, kStiffest = 1e6, kWithin = 1.01;
    if (rings(loop, kSoftest)) return 0.0;
    double holds = kSoftest, does = 2.0 * kSoftest;
    for (; !rings(loop, does); does *= 2.0) {
        if (does > kStiffest) return std::numeric_limits<double>::infinity();
        holds = does;
    }
    while (does > kWithin * holds) {
        const double middle = std::sqrt(holds * does);
        (rings(loop, middle) ? does : holds) = middle;
    }
    return holds;
}

}  // namespace haptable
