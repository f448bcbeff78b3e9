// SPDX-License-Identifier: GPL-2.0-or-later
// A scene of tables in memory, and the state that one step of it keeps: fingers, pose, modes.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "firmware/haptable_scene.h"

namespace haptable {

class SceneState {
public:
    /// pair, body, modes: null where the scene has none. All must outlive this object.
    SceneState(const haptable_model& model, const haptable_pair_model* pair, const haptable_body* body,
               const haptable_modes* modes) {
        haptable_scene_make(&model, pair, body, modes, &scene_);
        memory_.resize((scene_.bytes + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t));
        haptable_init(&scene_, memory_.data());
        if (body != nullptr) touched_ = *this->body();
    }

    /// haptable_step. in, out: [fingers()]
    void step(const haptable_input in[], std::uint32_t now_us, haptable_output out[]) {
        if (scene_.body != nullptr) touched_ = *body();
        haptable_step(&scene_, memory_.data(), in, now_us, out);
    }
    void check(std::uint32_t bytes) { haptable_check(&scene_, memory_.data(), bytes); }

    const haptable_scene& scene() const { return scene_; }
    std::size_t fingers() const { return scene_.pair != nullptr ? 2 : 1; }
    haptable_servo& servo(std::size_t finger) {
        return *haptable_scene_servo(memory_.data(), static_cast<int>(finger));
    }
    const haptable_servo& servo(std::size_t finger) const { return const_cast<SceneState*>(this)->servo(finger); }
    /// The state of two fingers; else null.
    haptable_pair* pair() {
        return scene_.pair != nullptr ? reinterpret_cast<haptable_pair*>(memory_.data()) : nullptr;
    }
    /// Null where the body is held.
    haptable_body_state* body() {
        return scene_.body != nullptr ? haptable_scene_body(&scene_, memory_.data()) : nullptr;
    }
    /// Where the body was in the last tick, whose contact is in its frame. Null where it is held.
    const haptable_body_state* touched() const { return scene_.body != nullptr ? &touched_ : nullptr; }
    /// How far the modes have swung by the end of the tick. Null where there are none.
    haptable_modes_state* modes() {
        return scene_.modes != nullptr ? haptable_scene_modes(&scene_, memory_.data()) : nullptr;
    }
    const haptable_modes_state* modes() const { return const_cast<SceneState*>(this)->modes(); }
    /// The account of a body that moves.
    const haptable_account& account() const {
        return *haptable_scene_account(&scene_, const_cast<std::max_align_t*>(memory_.data()));
    }
    /// A world position in the frame of the last tick.
    std::array<float, 3> inside(const std::array<float, 3>& world_m) const {
        std::array<float, 3> inside_m = world_m;
        if (scene_.body != nullptr) haptable_body_from_world(scene_.body, &touched_, world_m.data(), inside_m.data());
        return inside_m;
    }

private:
    haptable_scene scene_{};
    std::vector<std::max_align_t> memory_;
    haptable_body_state touched_{};
};

}  // namespace haptable
