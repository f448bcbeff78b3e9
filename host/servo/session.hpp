// SPDX-License-Identifier: GPL-2.0-or-later
// device_state in, servo_force and contact out: the servo as a partner of a device over LCM.
#pragma once

#include "host/link/clock.hpp"
#include "host/link/connection.hpp"
#include "host/link/live_state.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/servo/replay.hpp"
#include "host/session/answer.hpp"
#include "host/session/body_motion.hpp"
#include "host/session/counted.hpp"
#include "host/session/record.hpp"
#include "host/session/scene.hpp"
#include "host/session/state_gate.hpp"

namespace haptable {

/// What the link counts beside the firmware's own counters.
struct LinkReport : LinkCounters {
    DurationStatistics latency;  ///< from the arrival of a state to its answer
};

/// Answers its device's states at once, of several that wait in real time the newest alone. Single-threaded: everything
/// happens within connection.handle_until and the calls below, so the same code runs against a device in another
/// process and, over memq://, in this one.
class ServoSession {
public:
    /// Subscribes to states. `record` may be null. `tell` gets a line for each event, if it is there.
    ServoSession(const ServoScene& scene, Connection& connection, ServoRecord* record, LiveState::Tell tell = {},
                 const haptable_body* body = nullptr);
    ServoSession(const ServoSession&) = delete;
    ServoSession& operator=(const ServoSession&) = delete;

    /// The watchdog: after HAPTABLE_SILENCE_US without a state it drops the contact and publishes zero force, once.
    /// Simulated time stands still between states, so in lockstep there is no silence.
    void watch(Clock::time_point now);
    /// When watch has work again. Far away while there is nothing to watch.
    Clock::time_point watch_at() const;
    /// Publishes servo_status and begins a new count of the longest step.
    void publish_status();

    bool has_states() const { return gate_.has_states(); }
    /// When the device's last state came; begin of the session before.
    Clock::time_point last_state() const { return gate_.last_state(); }
    ServoReport report() const;
    LinkReport link_report() const;

private:
    void on_state(const device_state& state, std::int64_t received_utime);
    void answer_newest();
    void end_contact();
    void step();
    void tell();

    ServoScene scene_;
    Connection& connection_;
    ServoRecord* record_;
    Answer answer_;
    haptable_servo servo_;
    BodyMotion body_;
    haptable_output output_{};
    StateGate gate_;
    bool waits_ = false;               ///< the gate's state is not stepped yet
    bool begins_ = false;              ///< it, or one that it overtook, is a session's first
    std::int64_t received_utime_ = 0;  ///< of it
    ServoReport report_;
    LinkReport link_;
    double longest_step_us_ = 0.0;
    LiveState live_;
    std::array<float, 3> rejected_m_{};  ///< the last one
};

}  // namespace haptable
