// SPDX-License-Identifier: GPL-2.0-or-later
// servo_status under construction: what a servo, or the bridge that stands for it, publishes ten times a second.
#pragma once

#include <cstdint>
#include <string>

#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "host/session/answer.hpp"
#include "host/session/energy.hpp"

namespace haptable {

class Status {
public:
    /// `owner`: session of the device that has the servo.
    Status(const Answer& answer, std::int64_t owner, const haptable_output& output, double longest_us);

    /// For the lists of counters, which call it with name and value.
    void operator()(std::string name, std::int64_t value);
    /// The energies, in nJ. suffix: of the finger, at the end of each name.
    void add(const ForceReport& forces, const std::string& suffix = "");
    /// Counts what could not be read last, and publishes.
    void publish(Connection& connection);

private:
    servo_status message_{};
};

}  // namespace haptable
