// SPDX-License-Identifier: GPL-2.0-or-later
// Where a session's body is: of one that is held, where it was.
#pragma once

#include "firmware/haptable_body.h"
#include "firmware/haptable_modes_pair.h"
#include "host/link/channels.hpp"
#include "host/link/ringing.hpp"
#include "host/session/scene.hpp"

namespace haptable {

class BodyMotion {
public:
    /// body: null where it is held.
    BodyMotion(const ServoScene& scene, const haptable_body* body);

    /// One tick of one finger, 0 or 1, and of the body where it moves or rings: haptable_step. finger_m: world
    /// coordinates. Of a body that is not held out.force_n is along world axes, what else is in `out` in body
    /// coordinates.
    void step(haptable_pair& pair, int finger, const float finger_m[3], std::uint32_t now_us, haptable_output& out);

    /// The same of two fingers at once, where the scene has them: haptable_pair_step.
    void step(haptable_pair& pair, const float finger_m[2][3], std::uint32_t now_us, haptable_output out[2]);

    /// Where the body was in the last tick, whose contact is in its frame. Null where it is held.
    const haptable_body_state* state() const { return body_ != nullptr ? &touched_ : nullptr; }
    /// How far the modes have swung by the end of the tick. Null where the body does not ring.
    const haptable_swings* swings() const {
        if (scene_.modes == nullptr) return nullptr;
        return scene_.pair != nullptr ? &of_both_.swings : &of_one_.swings;
    }
    /// A world position in the frame of the last tick.
    std::array<float, 3> inside(const std::array<float, 3>& world_m) const;
    /// Of a body that is not held, for the answer to that state.
    body_pose message(const device_state& state, std::int64_t utime, std::int64_t servo) const;
    /// Of one that rings, likewise.
    body_modes modes_message(const device_state& state, std::int64_t utime, std::int64_t servo) const;

private:
    ServoScene scene_;
    const haptable_body* body_;
    haptable_body_state state_{}, touched_{};
    haptable_modes_state of_one_{};  ///< of a scene with one finger
    haptable_modes_pair of_both_{};  ///< of a scene with two
};

}  // namespace haptable
