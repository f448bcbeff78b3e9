// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/answer.hpp"

#include <algorithm>

namespace haptable {

// The message's words for what the firmware says.
static_assert(servo_force::SILENT == HAPTABLE_SILENT && servo_force::FREE == HAPTABLE_FREE &&
              servo_force::CONTACT == HAPTABLE_CONTACT && servo_force::REJECTED == HAPTABLE_REJECTED &&
              servo_force::LIMITED == HAPTABLE_LIMITED && servo_force::FAULTED == HAPTABLE_FAULTED);

Answer::Answer(const ServoScene& scene, Connection& connection) : scene_(scene), connection_(connection) {
    force_.servo = contact_.servo = random_session();
    force_.model_hash = contact_.model_hash = static_cast<std::int64_t>(scene.model->hash);
    contact_.node.reserve(3);
    contact_.force_n.resize(3);
    for (auto& force_n : contact_.force_n) force_n.reserve(3);
}

void Answer::refuse(const device_state& state, std::int64_t owner, std::size_t finger) {
    servo_force refusal{};
    refusal.utime = utime_now();
    refusal.seq = state.seq;
    refusal.session = state.session;
    refusal.servo = force_.servo;
    refusal.owner = owner;
    refusal.model_hash = force_.model_hash;
    connection_.publish(channel_of<servo_force>(finger), refusal);
}

void Answer::publish_force(const device_state& state, const haptable_output& output, std::int64_t utime,
                           std::size_t finger) {
    force_.utime = utime;
    force_.seq = state.seq;
    force_.session = force_.owner = state.session;
    std::copy_n(output.force_n, 3, force_.force_n);
    force_.servo_state = static_cast<std::int8_t>(output.state);
    force_.faults = output.faults;
    connection_.publish(channel_of<servo_force>(finger), force_);
}

void Answer::publish_contact(const device_state& state, const haptable_output& output, std::size_t finger) {
    contact_.utime = force_.utime;
    contact_.seq = state.seq;
    contact_.session = state.session;
    std::copy_n(state.position_m, 3, contact_.finger_m);
    std::copy_n(output.god_object_m, 3, contact_.god_object_m);
    std::copy_n(output.force_n, 3, contact_.felt_n);
    contact_.touches = static_cast<std::int8_t>(haptable_touches(output.state));
    contact_.node.clear();
    const bool has_dent = output.state == HAPTABLE_FREE && output.vertex[0] != HAPTABLE_NONE;
    for (std::size_t corner = 0; corner < 3 && (contact_.touches != 0 || has_dent); ++corner) {
        contact_.node.push_back(mesh_node(scene_, output, corner));
        contact_.force_n[corner].assign(output.nodal_force_n[corner], output.nodal_force_n[corner] + 3);
    }
    contact_.count = static_cast<std::int32_t>(contact_.node.size());
    connection_.publish(channel_of<contact>(finger), contact_);
}

}  // namespace haptable
