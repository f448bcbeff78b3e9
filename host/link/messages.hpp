// SPDX-License-Identifier: GPL-2.0-or-later
// The message types that lcm-gen makes from codegen/lcm/*.lcm: device_state, servo_force, contact, servo_status.
#pragma once

#include <cstdint>

// lcm-gen 1.3.1 writes implicit conversions for variable-size arrays.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#include "haptable/contact.hpp"
#include "haptable/device_state.hpp"
#include "haptable/servo_force.hpp"
#include "haptable/servo_status.hpp"
#pragma GCC diagnostic pop

namespace haptable {

inline constexpr const char* kStateChannel = "HAPTABLE_STATE";      ///< device_state, from the device
inline constexpr const char* kForceChannel = "HAPTABLE_FORCE";      ///< servo_force, from the servo
inline constexpr const char* kContactChannel = "HAPTABLE_CONTACT";  ///< contact, from the servo
inline constexpr const char* kStatusChannel = "HAPTABLE_STATUS";    ///< servo_status, from the servo

/// In lockstep the device's clock is simulated: it waits for every answer.
inline bool is_simulated(const device_state& state) { return state.mode == device_state::SIMULATED; }

/// As the firmware takes them.
inline std::uint32_t buttons_of(const device_state& state) { return static_cast<std::uint32_t>(state.buttons); }

/// A number that tells this run of a device or a servo from every other, never 0.
std::int64_t random_session();

}  // namespace haptable
