// SPDX-License-Identifier: GPL-2.0-or-later
// What a servo publishes for one state, whoever computed it: servo_force and contact.
#pragma once

#include "host/link/clock.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "host/session/scene.hpp"
#include "host/session/stepper.hpp"

namespace haptable {

/// The firmware's wrapping clock.
inline std::uint32_t to_firmware_us(Clock::time_point now) {
    return static_cast<std::uint32_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count());
}

class Answer {
public:
    Answer(const ServoScene& scene, Connection& connection);

    std::int64_t model_hash() const { return force_.model_hash; }
    /// The servo's name in its messages: a random number for each run.
    std::int64_t servo() const { return force_.servo; }
    /// Tells another device whose the servo, or this finger of it, is, with no force.
    void refuse(const device_state& state, std::int64_t owner, std::size_t finger = 0);
    /// utime: of the tick; answers of one tick have the same.
    void publish_force(const device_state& state, const haptable_output& output, std::int64_t utime,
                       std::size_t finger = 0);
    /// Before publish_force, whose time it has.
    void publish_wrench(const device_state& state, const ToolOutput& tool, std::int64_t utime);
    /// After publish_force of that finger. tool: null, or its points' loads are listed in place of the output's.
    void publish_contact(const device_state& state, const haptable_output& output, std::size_t finger = 0,
                         const ToolOutput* tool = nullptr);

private:
    void add_loads(const haptable_output& output);

    ServoScene scene_;
    Connection& connection_;
    servo_force force_{};
    contact contact_{};
    tool_wrench wrench_{};
};

}  // namespace haptable
