// SPDX-License-Identifier: GPL-2.0-or-later
// What stands behind the pointers of haptable_library.h. Both hold the object: whichever is freed last frees it.
#pragma once

#include <array>
#include <memory>

#include "host/library/object.hpp"
#include "host/session/energy.hpp"
#include "host/session/scene_state.hpp"

struct haptable_object {
    std::shared_ptr<const haptable::LoadedObject> loaded;
};

struct haptable_finger {
    std::shared_ptr<const haptable::LoadedObject> loaded;
    haptable::SceneState state;
    haptable::EnergyAccount energy;
    std::uint32_t buttons = 0;  ///< held down
};

struct haptable_fingers {
    std::shared_ptr<const haptable::LoadedObject> loaded;
    haptable::SceneState state;
    std::array<haptable::EnergyAccount, HAPTABLE_FINGERS> energy;
    std::array<std::uint32_t, HAPTABLE_FINGERS> buttons{};  ///< held down
};
