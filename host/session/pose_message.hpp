// SPDX-License-Identifier: GPL-2.0-or-later
// Where a body that nothing holds is, and how far one that rings has swung, as messages.
#pragma once

#include <algorithm>

#include "firmware/haptable_body.h"
#include "firmware/haptable_modes.h"
#include "host/link/messages.hpp"

namespace haptable {

/// With position, turn, velocity, spin and on_floor of `at`; whose it is remains to be filled in.
inline body_pose to_pose_message(const haptable_body& body, const haptable_body_state& at) {
    body_pose pose{};
    std::copy_n(body.centre_m, 3, pose.rest_centre_m);
    std::copy_n(at.position_m, 3, pose.centre_m);
    std::copy_n(at.turn, 4, pose.turn);
    std::copy_n(at.velocity_m_per_s, 3, pose.velocity_m_per_s);
    std::copy_n(at.spin_rad_per_s, 3, pose.spin_rad_per_s);
    pose.on_floor = at.on_floor;
    return pose;
}

/// Likewise.
inline body_modes to_modes_message(const haptable_modes& modes, const haptable_modes_state& swings) {
    static_assert(std::size(decltype(body_modes::swung){}) == HAPTABLE_MODES);
    body_modes message{};
    message.count = modes.count;
    std::copy_n(swings.q, modes.count, message.swung);
    return message;
}

/// What tells whose a message is: of the servo's answer to that state.
template <typename Message>
Message addressed(Message message, const device_state& state, std::int64_t utime, std::int64_t servo,
                  const haptable_model& model) {
    message.utime = utime;
    message.seq = state.seq;
    message.session = state.session;
    message.servo = servo;
    message.model_hash = static_cast<std::int64_t>(model.hash);
    return message;
}

}  // namespace haptable
