// SPDX-License-Identifier: GPL-2.0-or-later
// The scene's words for how an object is touched, and the firmware's functions that do it.
#pragma once

#include "firmware/haptable_model.h"
#include "host/base/limits.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

static_assert(kServoTick_s == 1e-6 * HAPTABLE_TICK_US);

/// What a tick does to a term's load: by which part it falls, and what is left of a change that came during the tick.
struct TickRelaxation {
    double fall, rise;
};
TickRelaxation relaxation_of_tick(const RelaxationTerm& term);

/// Sets the functions that the tables' options choose, and the numbers that these take; not how blocks are unpacked.
void set_laws(const Tables& tables, haptable_model& model);

/// How blocks stored as this are unpacked; null for float32.
haptable_unpack_fn* unpack_of(Storage precision);

}  // namespace haptable
