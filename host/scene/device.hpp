// SPDX-License-Identifier: GPL-2.0-or-later
// [device]: what the simulated device is like, and how a device's hand is placed at the body.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "host/base/limits.hpp"

namespace haptable {

/// A point device with motors. docs/DEVICES.md cites where the models' figures come from; the default is "phantom".
struct Device {
    std::string model = "phantom";                       ///< whose figures stand where the scene gives none
    double max_force_n = 8.5;                            ///< of the motors, at the device's end
    double continuous_force_n = 1.4;                     ///< that they give all day: for the mean force, not simulated
    std::array<double, 3> mass_kg{0.075, 0.075, 0.075};  ///< apparent, along the device's axes
    double damping_n_s_per_m = 0.005;
    double friction_n = 0.04;  ///< Coulomb friction
    double encoder_step_m = 3.0e-5;
    double bandwidth_hz = 0.0;                     ///< of the motors, a lag of first order; 0: none
    double delay_s = 0.0;                          ///< of a force on its way to the motors
    double unbalanced = 0.0;                       ///< share of the weight that nothing balances
    std::array<double, 3> up{0.0, 0.0, 1.0};       ///< against gravity, in the device's coordinates
    SafetyLimits limits;                           ///< none of them; a scene file has its own defaults (SCENE.md)
    std::array<double, 3> reach_m{0.0, 0.0, 0.0};  ///< between mechanical stops, about the origin; 0: endless

    bool operator==(const Device&) const = default;
};

/// Device coordinates to body coordinates: x_body = position + motion_scale R M x_device, M mirrors the first axis of a
/// left-handed device. Forces go back as force_scale (R M)^T F.
struct DeviceMap {
    std::array<double, 3> position_m{0.0, 0.0, 0.0};    ///< of the device's origin, in body coordinates
    std::array<double, 3> rotation_deg{0.0, 0.0, 0.0};  ///< about the body's x, then y, then z
    bool left_handed = false;
    double motion_scale = 1.0;
    double force_scale = 1.0;
    double ramp_s = 0.1;                               ///< in which the force falls and comes back
    std::optional<std::array<double, 6>> workspace_m;  ///< device coordinates; outside of it the force falls
};

}  // namespace haptable
