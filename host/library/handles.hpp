// SPDX-License-Identifier: GPL-2.0-or-later
// What stands behind the pointers of haptable_library.h. Both hold the object: whichever is freed last frees it.
#pragma once

#include <array>
#include <memory>

#include "firmware/haptable.h"
#include "firmware/haptable_body_modes.h"
#include "firmware/haptable_body_modes_pair.h"
#include "firmware/haptable_body_pair.h"
#include "firmware/haptable_modes_pair.h"
#include "firmware/haptable_pair.h"
#include "host/library/object.hpp"
#include "host/session/energy.hpp"

namespace haptable {

/// Where a body that nothing holds is, and how far one that rings has swung; of one that is held still nothing.
struct MovingBody {
    explicit MovingBody(const LoadedObject& object) : body(object.body()) {
        if (body != nullptr) haptable_body_init(body, &state);
        touched = state;
        if (object.modes() != nullptr) modes = *object.modes();
        haptable_modes_init(&of_one);
        haptable_modes_pair_init(&of_both);
    }
    bool rings() const { return modes.count > 0; }

    const haptable_body* body;
    haptable_body_state state{};
    haptable_body_state touched{};  ///< in the last tick, whose contacts are in its frame
    haptable_modes modes{};         ///< the object's, but of the servo's own model
    haptable_modes_state of_one{};
    haptable_modes_pair of_both{};
};

}  // namespace haptable

struct haptable_object {
    std::shared_ptr<const haptable::LoadedObject> loaded;
};

struct haptable_finger {
    std::shared_ptr<const haptable::LoadedObject> loaded;
    haptable::MovingBody body;
    haptable_servo servo;
    haptable::EnergyAccount energy;
    haptable_model model;      ///< the object's, but that it remembers for this finger alone
    haptable_relaxed relaxed;  ///< where the body relaxes
    haptable_freed freed;      ///< where there is friction
};

struct haptable_fingers {
    std::shared_ptr<const haptable::LoadedObject> loaded;
    haptable::MovingBody body;
    haptable_model alone;  ///< the object's, for one finger while the other is away: it remembers for these alone
    haptable_pair pair;
    std::array<haptable_freed, HAPTABLE_FINGERS> freed;  ///< where there is friction
    std::array<haptable::EnergyAccount, HAPTABLE_FINGERS> energy;
};
