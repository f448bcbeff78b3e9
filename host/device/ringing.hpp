// SPDX-License-Identifier: GPL-2.0-or-later
// When does a device ring? A finger deep in a body is a spring about a point, sampled once a tick and held. Where it
// gives more energy in a cycle than friction and hand take, the oscillation grows.
#pragma once

#include "host/device/point_device.hpp"
#include "host/scene/device.hpp"

namespace haptable {

struct RingingLoop {
    Device device;
    Hand hand{0.0, 0.0};     ///< holds the device at the spring's middle; none by default, which is the worst
    double speed_m_s = 0.5;  ///< of the oscillation's middle: codegen's promise is up to 0.5 m/s
};

/// True where an oscillation of that speed along the device's first axis grows under a spring of `stiffness_n_per_m`:
/// the device itself in lockstep, its encoder's steps, its delay and lag, its motors' limit.
bool rings(const RingingLoop& loop, double stiffness_n_per_m);

/// The stiffness from which on it rings, N/m, within 1 %: doubled from 1 N/m, then halved between. 0 where it rings at
/// 1 N/m; infinite where it does not at 1e6 N/m.
double ringing_stiffness(const RingingLoop& loop);

}  // namespace haptable
