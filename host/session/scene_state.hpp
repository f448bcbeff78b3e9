// SPDX-License-Identifier: GPL-2.0-or-later
// A scene of tables in memory, and the state that one step of it keeps: fingers or a tool, pose, modes.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "firmware/haptable.h"
#include "firmware/haptable_hands.h"
#include "firmware/haptable_tool.h"

namespace haptable {

class SceneState {
public:
    /// pair, body, modes, tool: null where the scene has none. All must outlive this object.
    SceneState(const haptable_model& model, const haptable_pair_model* pair, const haptable_body* body,
               const haptable_modes* modes, const haptable_tool_model* tool = nullptr)
        : tool_(tool) {
        if (tool != nullptr)
            haptable_tool_scene_make(&model, tool, &scene_);
        else if (pair != nullptr && pair->finger_count > HAPTABLE_FINGERS)
            haptable_hands_scene_make(pair, &hands_, &scene_);
        else
            haptable_scene_make(&model, pair, body, modes, &scene_.scene);
        memory_.resize((scene().bytes + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t));
        haptable_init(&scene(), memory_.data());
        if (body != nullptr) touched_ = *this->body();
    }

    SceneState(const SceneState&) = delete;
    SceneState& operator=(const SceneState&) = delete;

    /// haptable_step. in, out: [fingers()]
    void step(const haptable_input in[], std::uint32_t now_us, haptable_output out[]) {
        if (scene_.scene.body != nullptr) touched_ = *body();
        haptable_step(&scene_.scene, memory_.data(), in, now_us, out);
    }
    /// The same of a scene with a tool.
    void step(const haptable_tool_input& in, std::uint32_t now_us, haptable_tool_output& out) {
        haptable_step(&scene(), memory_.data(), &in.hand, now_us, &out.hand);
    }
    /// As after silence.
    void release(std::uint32_t now_us, haptable_tool_output& out) {
        haptable_tool_watch(&scene(), memory_.data(), now_us, &out);
    }
    /// A point's contact in the last tick.
    haptable_output point(std::size_t i) const {
        haptable_output out{};
        haptable_tool_point_of(&scene(), memory_.data(), static_cast<int>(i), &out);
        return out;
    }
    /// Stored by the points of the tool after the last tick.
    double tool_energy_j() const { return double{points().energy_j}; }
    /// Of a tool, or of three fingers and more.
    const haptable_points& points() const { return *haptable_points_of(scene_.points, memory()); }
    const haptable_points_model* scene_points() const { return scene_.points; }
    void* memory() const { return const_cast<std::max_align_t*>(memory_.data()); }
    void check(std::uint32_t bytes) { haptable_check(&scene(), memory_.data(), bytes); }

    const haptable_scene& scene() const { return scene_.scene; }
    /// Null where the scene has none.
    const haptable_tool_model* tool() const { return tool_; }
    std::size_t fingers() const { return static_cast<std::size_t>(haptable_scene_fingers(&scene_.scene)); }
    haptable_servo& servo(std::size_t finger) {
        return *haptable_scene_servo(memory_.data(), static_cast<int>(finger));
    }
    const haptable_servo& servo(std::size_t finger) const { return const_cast<SceneState*>(this)->servo(finger); }
    /// Of a scene with a tool.
    haptable_point& point_state(std::size_t i) { return haptable_points_in(scene_.points, memory())[i]; }
    haptable_servo& point_servo(std::size_t i) { return haptable_points_servos(scene_.points, memory())[i]; }
    /// The state of two fingers; else null.
    haptable_pair* pair() {
        return fingers() == HAPTABLE_FINGERS ? reinterpret_cast<haptable_pair*>(memory_.data()) : nullptr;
    }
    /// Null where the body is held.
    haptable_body_state* body() {
        return scene_.scene.body != nullptr ? haptable_scene_body(&scene_.scene, memory_.data()) : nullptr;
    }
    /// Where the body was in the last tick, whose contact is in its frame. Null where it is held.
    const haptable_body_state* touched() const { return scene_.scene.body != nullptr ? &touched_ : nullptr; }
    /// How far the modes have swung by the end of the tick. Null where there are none.
    haptable_modes_state* modes() {
        return scene_.scene.modes != nullptr ? haptable_scene_modes(&scene_.scene, memory_.data()) : nullptr;
    }
    const haptable_modes_state* modes() const { return const_cast<SceneState*>(this)->modes(); }
    /// The account of a body that moves.
    const haptable_account& account() const {
        return *haptable_scene_account(&scene_.scene, const_cast<std::max_align_t*>(memory_.data()));
    }
    /// A world position in the frame of the last tick.
    std::array<float, 3> inside(const std::array<float, 3>& world_m) const {
        std::array<float, 3> inside_m = world_m;
        if (scene_.scene.body != nullptr)
            haptable_body_from_world(scene_.scene.body, &touched_, world_m.data(), inside_m.data());
        return inside_m;
    }

private:
    const haptable_tool_model* tool_;
    haptable_points_scene scene_{};  ///< of one finger or two its first member
    haptable_points_model hands_{};  ///< of three and more
    std::vector<std::max_align_t> memory_;
    haptable_body_state touched_{};
};

}  // namespace haptable
