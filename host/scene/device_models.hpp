// SPDX-License-Identifier: GPL-2.0-or-later
// Devices by name: published figures, each with where it stands, and what was assumed where none was found.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/scene/device.hpp"

namespace haptable {

/// A number and its source: a key of docs/DEVICES.md, "assumed" where none was found.
struct Figure {
    double value;
    const char* source;
};

struct DeviceModel {
    const char* name;   ///< as a scene and --device have it
    const char* title;  ///< as its maker calls it
    Figure max_force_n, continuous_force_n, mass_kg, friction_n, damping_n_s_per_m, encoder_step_m, bandwidth_hz,
        delay_s, unbalanced;
    std::array<double, 3> reach_m;  ///< about the origin; 0: endless
    const char* reach_source;
    std::array<double, 3> up;
};

/// All of them; the first is the default.
const std::vector<DeviceModel>& device_models();

/// Null for a name that there is not.
const DeviceModel* find_device_model(const std::string& name);

/// What a scene that names the model alone describes.
Device device_of(const DeviceModel& model);

}  // namespace haptable
