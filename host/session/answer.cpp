// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/answer.hpp"

#include <algorithm>

namespace haptable {

// The message's words for what the firmware says.
static_assert(servo_force::SILENT == HAPTABLE_SILENT && servo_force::FREE == HAPTABLE_FREE &&
              servo_force::CONTACT == HAPTABLE_CONTACT && servo_force::REJECTED == HAPTABLE_REJECTED &&
              servo_force::LIMITED == HAPTABLE_LIMITED && servo_force::FAULTED == HAPTABLE_FAULTED);

Answer::Answer(const ServoScene& scene, Connection& connection) : scene_(scene), connection_(connection) {
    force_.servo = contact_.servo = wrench_.servo = random_session();
    force_.model_hash = contact_.model_hash = wrench_.model_hash = static_cast<std::int64_t>(scene.model->hash);
    const std::size_t most = 3 * (scene.tool != nullptr ? std::size_t{HAPTABLE_POINTS} : 1);
    contact_.node.reserve(most);
    contact_.force_n.assign(most, std::vector<double>(3));
    if (scene.tool == nullptr) return;
    wrench_.touches.reserve(HAPTABLE_POINTS);
    wrench_.point_m = wrench_.god_object_m = wrench_.force_n = contact_.force_n;
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

void Answer::publish_wrench(const device_state& state, const ToolOutput& tool, std::int64_t utime) {
    wrench_.utime = utime;
    wrench_.seq = state.seq;
    wrench_.session = state.session;
    std::copy_n(tool.torque_n_m.begin(), 3, wrench_.torque_n_m);
    std::copy_n(tool.position_m.begin(), 3, wrench_.position_m);
    std::copy_n(tool.turn.begin(), 4, wrench_.turn);
    wrench_.count = static_cast<std::int32_t>(tool.point.size());
    wrench_.touches.clear();
    for (const haptable_output& point : tool.point) {
        const std::size_t at = wrench_.touches.size();
        wrench_.touches.push_back(static_cast<std::int8_t>(haptable_touches(point.state)));
        wrench_.point_m[at].assign(tool.point_m[at].begin(), tool.point_m[at].end());
        wrench_.god_object_m[at].assign(point.god_object_m, point.god_object_m + 3);
        wrench_.force_n[at].assign(point.force_n, point.force_n + 3);
    }
    connection_.publish(channel_of<tool_wrench>(), wrench_);
}

/// The loaded nodes of a contact, or of a dent.
void Answer::add_loads(const haptable_output& output) {
    const bool has_dent = output.state == HAPTABLE_FREE && output.vertex[0] != HAPTABLE_NONE;
    for (std::size_t corner = 0; corner < 3 && (haptable_touches(output.state) != 0 || has_dent); ++corner) {
        contact_.force_n[contact_.node.size()].assign(output.nodal_force_n[corner], output.nodal_force_n[corner] + 3);
        contact_.node.push_back(mesh_node(scene_, output, corner));
    }
}

void Answer::publish_contact(const device_state& state, const haptable_output& output, std::size_t finger,
                             const ToolOutput* tool) {
    contact_.utime = force_.utime;
    contact_.seq = state.seq;
    contact_.session = state.session;
    std::copy_n(state.position_m, 3, contact_.finger_m);
    std::copy_n(output.god_object_m, 3, contact_.god_object_m);
    std::copy_n(output.force_n, 3, contact_.felt_n);
    contact_.touches = static_cast<std::int8_t>(haptable_touches(output.state));
    contact_.node.clear();
    if (tool == nullptr) add_loads(output);
    for (std::size_t i = 0; tool != nullptr && i < tool->point.size(); ++i) add_loads(tool->point[i]);
    contact_.count = static_cast<std::int32_t>(contact_.node.size());
    connection_.publish(channel_of<contact>(finger), contact_);
}

}  // namespace haptable
