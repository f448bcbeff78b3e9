// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/body_motion.hpp"

#include <algorithm>

#include "firmware/haptable_body_modes.h"
#include "firmware/haptable_body_modes_pair.h"
#include "firmware/haptable_body_pair.h"
#include "host/session/pose_message.hpp"

namespace haptable {

BodyMotion::BodyMotion(const ServoScene& scene, const haptable_body* body) : scene_(scene), body_(body) {
    if (body != nullptr) haptable_body_init(body, &state_);
    touched_ = state_;
    haptable_modes_init(&of_one_);
    haptable_modes_pair_init(&of_both_);
}

void BodyMotion::step(haptable_pair& pair, int finger, const float finger_m[3], std::uint32_t now_us,
                      haptable_output& out) {
    haptable_servo& servo = pair.servo[finger];
    if (body_ == nullptr && scene_.modes != nullptr && scene_.pair != nullptr)
        return haptable_modes_pair_step_finger(scene_.modes, scene_.pair, &of_both_, &pair, finger, finger_m, now_us,
                                               &out);
    if (body_ == nullptr && scene_.modes != nullptr)
        return haptable_modes_step(scene_.modes, &of_one_, &servo, finger_m, now_us, &out);
    if (body_ == nullptr) return haptable_step(scene_.model, &servo, finger_m, now_us, &out);
    touched_ = state_;
    if (scene_.modes != nullptr && scene_.pair != nullptr)
        return haptable_body_modes_pair_step_finger(scene_.modes, scene_.pair, body_, &state_, &of_both_, &pair, finger,
                                                    finger_m, now_us, &out);
    if (scene_.modes != nullptr)
        return haptable_body_modes_step(scene_.modes, body_, &state_, &of_one_, &servo, finger_m, now_us, &out);
    haptable_body_step_finger(scene_.model, body_, &state_, &servo, finger, finger_m, now_us, &out);
}

void BodyMotion::step(haptable_pair& pair, const float finger_m[2][3], std::uint32_t now_us, haptable_output out[2]) {
    if (body_ == nullptr && scene_.modes != nullptr)
        return haptable_modes_pair_step(scene_.modes, scene_.pair, &of_both_, &pair, finger_m, now_us, out);
    if (body_ == nullptr) return haptable_pair_step(scene_.pair, &pair, finger_m[0], finger_m[1], now_us, out);
    touched_ = state_;
    if (scene_.modes != nullptr)
        return haptable_body_modes_pair_step(scene_.modes, scene_.pair, body_, &state_, &of_both_, &pair, finger_m,
                                             now_us, out);
    haptable_body_pair_step(scene_.pair, body_, &state_, &pair, finger_m, now_us, out);
}

std::array<float, 3> BodyMotion::inside(const std::array<float, 3>& world_m) const {
    if (body_ == nullptr) return world_m;
    std::array<float, 3> inside_m{};
    haptable_body_from_world(body_, &touched_, world_m.data(), inside_m.data());
    return inside_m;
}

body_modes BodyMotion::modes_message(const device_state& state, std::int64_t utime, std::int64_t servo) const {
    return addressed(to_modes_message(*scene_.modes, *swings()), state, utime, servo, *scene_.model);
}

body_pose BodyMotion::message(const device_state& state, std::int64_t utime, std::int64_t servo) const {
    return addressed(to_pose_message(*body_, touched_), state, utime, servo, *scene_.model);
}

}  // namespace haptable
