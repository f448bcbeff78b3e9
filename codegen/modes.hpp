// SPDX-License-Identifier: GPL-2.0-or-later
// The scene's words for how an object is touched, and the firmware's functions that do it.
#pragma once

#include "firmware/haptable.h"
#include "host/tables/tables.hpp"

namespace haptable {

/// A function of the firmware and its name in C.
template <typename Function>
struct Named {
    const char* name = nullptr;
    Function* function = nullptr;
};

/// What a model names, as its scene chose.
struct Modes {
    Named<haptable_god_object_fn> god_object;
    Named<haptable_force_fn> force;
    Named<haptable_god_object_fn> frictionless;  ///< what friction holds back; or null
    Named<haptable_finish_fn> release;           ///< or null
    Named<haptable_finish_fn> passivity;         ///< or null
    Named<haptable_energy_fn> energy;            ///< of that force where the god-object needs it; or null
    Named<haptable_unpack_fn> unpack;            ///< null for float32
};

Modes modes_of(const Tables& tables);

/// Sets the functions that the tables' options choose, and the numbers that these take; not how blocks are unpacked.
void set_modes(const Tables& tables, haptable_model& model);

}  // namespace haptable
