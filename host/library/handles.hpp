// SPDX-License-Identifier: GPL-2.0-or-later
// What stands behind the pointers of haptable_library.h. Both hold the object: whichever is freed last frees it.
#pragma once

#include <memory>

#include "firmware/haptable.h"
#include "host/library/object.hpp"
#include "host/session/energy.hpp"

struct haptable_object {
    std::shared_ptr<const haptable::LoadedObject> loaded;
};

struct haptable_finger {
    std::shared_ptr<const haptable::LoadedObject> loaded;
    haptable_servo servo;
    haptable::EnergyAccount energy;
    haptable_model model;      ///< the object's, but that it remembers for this finger alone
    haptable_relaxed relaxed;  ///< where the body relaxes
};
