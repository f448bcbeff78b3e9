// SPDX-License-Identifier: GPL-2.0-or-later
// What a servo program is made for: the tables of one scene, linked into it.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "firmware/haptable_model.h"
#include "host/base/error.hpp"
#include "host/session/scene_state.hpp"

namespace haptable {

struct ServoScene {
    const haptable_model* model;                ///< the firmware's tables
    const std::uint32_t* node;                  ///< [model->vertex_count] mesh node of every vertex of the model
    const char* name;                           ///< of the scene
    const haptable_pair_model* pair = nullptr;  ///< of its fingers; null: one
    const haptable_modes* modes = nullptr;      ///< its modes; null: it follows at once
    const haptable_body* body = nullptr;        ///< of one that nothing holds; null: it is held
    const haptable_tool_model* tool = nullptr;  ///< that the hand holds; null: a finger, or two
};

inline std::size_t fingers_of(const ServoScene& scene) { return scene.pair != nullptr ? scene.pair->finger_count : 1; }

/// A finger position as the servo takes it. A double beyond the range of floats becomes infinite (IEEE 754), which
/// the servo rejects by name.
inline std::array<float, 3> to_finger(const double position_m[3]) {
    return {static_cast<float>(position_m[0]), static_cast<float>(position_m[1]), static_cast<float>(position_m[2])};
}

/// A tool's orientation as the servo takes it, w x y z; the same.
inline std::array<float, 4> to_turn(const double turn[4]) {
    return {static_cast<float>(turn[0]), static_cast<float>(turn[1]), static_cast<float>(turn[2]),
            static_cast<float>(turn[3])};
}

/// A state that knows no finger yet.
inline SceneState state_of(const ServoScene& scene) {
    return {*scene.model, scene.pair, scene.body, scene.modes, scene.tool};
}

/// The check before the first force. Throws Error where the tables are not what codegen wrote.
inline void require_whole_tables(const ServoScene& scene, SceneState& state) {
    state.check(HAPTABLE_CHECK_ALL);
    if ((state.servo(0).faults & HAPTABLE_FAULT_TABLES) != 0)
        throw Error(std::string("the tables of ") + scene.name +
                    " are damaged (their CRC is wrong): build this servo again");
}

/// Mesh node of one corner of the patch that the god-object is on; -1 without contact.
inline std::int32_t mesh_node(const ServoScene& scene, const haptable_output& out, std::size_t corner) {
    const std::uint16_t vertex = out.vertex[corner];
    return vertex == HAPTABLE_NONE ? -1 : static_cast<std::int32_t>(scene.node[vertex]);
}

}  // namespace haptable
