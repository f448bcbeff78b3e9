// SPDX-License-Identifier: GPL-2.0-or-later
// What stands behind the pointers of haptable_library.h. Both hold the object: whichever is freed last frees it.
#pragma once

#include <array>
#include <memory>

#include "firmware/haptable.h"
#include "firmware/haptable_pair.h"
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
    haptable_freed freed;      ///< where there is friction
};

struct haptable_fingers {
    std::shared_ptr<const haptable::LoadedObject> loaded;
    haptable_pair pair;
    std::array<haptable_freed, HAPTABLE_FINGERS> freed;  ///< where there is friction
    std::array<haptable::EnergyAccount, HAPTABLE_FINGERS> energy;
};
