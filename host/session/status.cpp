// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/status.hpp"

#include <fmt/format.h>

#include <cmath>

namespace haptable {

Status::Status(const Answer& answer, std::int64_t owner, const haptable_output& output, double longest_us) {
    message_.utime = utime_now();
    message_.session = owner;
    message_.servo = answer.servo();
    message_.model_hash = answer.model_hash();
    message_.servo_state = static_cast<std::int8_t>(output.state);
    message_.faults = output.faults;
    message_.longest_step_us = longest_us;
}

void Status::operator()(std::string name, std::int64_t value) {
    message_.name.push_back(std::move(name));
    message_.value.push_back(value);
}

void Status::add(const ForceReport& forces, const std::string& suffix) {
    for (const auto& [name, energy_j] : forces.energy.by_name())
        (*this)(fmt::format("{}_nj{}", name, suffix), std::llround(energy_j * 1e9));
}

void Status::publish(Connection& connection) {
    (*this)("undecodable_messages", static_cast<std::int64_t>(connection.undecodable()));
    message_.count = static_cast<std::int32_t>(message_.name.size());
    connection.publish(channel_of<servo_status>(), message_);
}

}  // namespace haptable
