// SPDX-License-Identifier: GPL-2.0-or-later
// What keeps a servo's force in bounds beside max_force: of a scene, and of the tables that are made from it.
#pragma once

namespace haptable {

/// 0: without that limit, and without a byte of it in the firmware (docs/SAFETY.md).
struct SafetyLimits {
    double max_speed_m_s = 0.0;           ///< of a finger: faster, and a position is not believed
    double max_force_rate_n_per_s = 0.0;  ///< by which the force rises
    double mean_force_n = 0.0;            ///< root of the mean of the squared force
    double mean_force_time_s = 30.0;      ///< of the filter of first order that takes that mean
    double ramp_s = 0.0;  ///< in which a force comes back inside the body; 0: after the finger has left it
    bool grab = false;    ///< a button holds the contact
    bool check = false;   ///< of the tables' CRC, before the first force and again

    bool operator==(const SafetyLimits&) const = default;
};

}  // namespace haptable
