// SPDX-License-Identifier: GPL-2.0-or-later
// The scene's words for how an object is touched, and the firmware's functions that do it.
#pragma once

#include <string>

#include "firmware/haptable.h"
#include "host/tables/tables.hpp"

namespace haptable {

/// A function of the firmware and its name in C.
template <typename Function>
struct Named {
    const char* name;
    Function* function;
};

/// What a model names, as its scene chose.
struct Modes {
    Named<haptable_god_object_fn> god_object;
    Named<haptable_force_fn> force;
    Named<haptable_unpack_fn> unpack;  ///< "0", null for float32
    Named<haptable_energy_fn> energy;  ///< of that force where the god-object needs it; or "0", null
};

/// Throws Error when the tables ask for a mode that this version does not have.
Modes modes_of(const Tables& tables);

}  // namespace haptable
