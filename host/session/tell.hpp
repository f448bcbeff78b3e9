// SPDX-License-Identifier: GPL-2.0-or-later
// What a servo's side of a session tells its user while it runs: who else is on the channel, what it does not believe.
#pragma once

#include <array>
#include <string>

#include "firmware/haptable_model.h"
#include "host/link/live_state.hpp"
#include "host/session/counted.hpp"

namespace haptable {

/// Tells of states that were not the servo's next: of another scene, of a device that has another servo, of a second
/// device, too old ones. who: begins each line; empty where there is one finger.
void tell_of_states(const StateCounters& counters, Clock::time_point now, LiveState& live, const std::string& who = "");

/// A rejected position, m, and what is likely to be wrong with it.
std::string why_rejected(const haptable_model& model, const std::array<float, 3>& position_m);

/// "contact dropped after a silence of 21 ms"
std::string contact_dropped_after(Clock::duration silence);

}  // namespace haptable
