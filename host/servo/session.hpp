// SPDX-License-Identifier: GPL-2.0-or-later
// device_state in, servo_force and contact out: the servo as a partner of a device over LCM, or of one for each finger.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/link/clock.hpp"
#include "host/link/connection.hpp"
#include "host/link/live_state.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/servo/replay.hpp"
#include "host/session/answer.hpp"
#include "host/session/counted.hpp"
#include "host/session/fingers.hpp"
#include "host/session/record.hpp"
#include "host/session/scene.hpp"
#include "host/session/state_gate.hpp"

namespace haptable {

/// What the link counts beside the firmware's own counters.
struct LinkReport : LinkCounters {
    DurationStatistics latency;  ///< from the arrival of a state to its answer
};

/// Answers its devices' states at once, of several that wait in real time the newest alone. Of two fingers a tick is
/// both: a state waits for the other's, in real time for a millisecond. Single-threaded: everything happens within
/// connection.handle_until and the calls below, so the same code runs against a device in another process and, over
/// memq://, in this one.
class ServoSession {
public:
    /// Subscribes to states. `record` may be null. `tell` gets a line for each event, if it is there.
    ServoSession(const ServoScene& scene, Connection& connection, ServoRecord* record, LiveState::Tell tell = {});
    ServoSession(const ServoSession&) = delete;
    ServoSession& operator=(const ServoSession&) = delete;

    /// The watchdog: after HAPTABLE_SILENCE_US without a state it drops the contact and publishes zero force, once; and
    /// steps who has waited for the other finger. Simulated time stands still between states, so in lockstep there is
    /// no silence, but for a finger whose device is gone while the other waits.
    void watch(Clock::time_point now);
    /// When watch has work again. Far away while there is nothing to watch.
    Clock::time_point watch_at() const;
    /// Publishes servo_status and begins a new count of the longest step.
    void publish_status();

    bool has_states() const;
    /// When a device's last state came; begin of the session before.
    Clock::time_point last_state() const;
    std::size_t finger_count() const { return fingers_.count(); }
    /// Energy given to the hands together, the largest so far, J.
    double most_given_j() const { return fingers_.most_given_j(); }
    ServoReport report(std::size_t finger = 0) const { return fingers_.report(finger); }
    LinkReport link_report(std::size_t finger = 0) const;

private:
    /// A finger's device and what waits of it.
    struct Side {
        explicit Side(const StateGate& of) : gate(of) {}

        StateGate gate;
        bool waits = false;                 ///< the gate's state is not stepped yet
        bool begins = false;                ///< it, or one that it overtook, is a session's first
        bool is_late = false;               ///< the other has waited for it in vain: it is not waited for again
        std::int64_t received_utime = 0;    ///< of the state that waits
        Clock::time_point waits_since{};    ///< since the first that it stands for
        std::int64_t clock_us = 0;          ///< simulated: the servo's time less the device's
        std::int64_t answered_utime = 0;    ///< of the last answer
        std::array<float, 3> at_m{};        ///< of the last state
        std::array<float, 3> rejected_m{};  ///< the last position that was
        LinkReport link;
    };

    void subscribe(std::size_t finger);
    void on_state(std::size_t finger, const device_state& state, std::int64_t received_utime);
    bool is_of_other_time(std::size_t finger, const device_state& state) const;
    bool is_there(std::size_t finger, Clock::time_point now) const;
    bool is_ready(Clock::time_point now) const;
    void step_if_ready();
    void step(Clock::time_point now);
    std::size_t leading() const;
    void set_time(std::int64_t utime);
    FingerInputs inputs(Clock::time_point now) const;
    void answer(std::size_t lead);
    void record(const FingerInputs& in, std::int64_t number);
    void end_tick(const FingerInputs& in);
    Clock::time_point silent_at(std::size_t finger) const;
    void watch(std::size_t finger, Clock::time_point now);
    std::string who(std::size_t finger) const;
    void tell();
    void tell(std::size_t finger, Clock::time_point now);

    ServoScene scene_;
    Connection& connection_;
    ServoRecord* record_;
    Answer answer_;
    Fingers fingers_;
    std::vector<Side> side_;
    TickNumbers numbers_;
    std::int64_t tick_utime_ = 0;  ///< of the last tick
    double longest_step_us_ = 0.0;
    LiveState live_;
};

}  // namespace haptable
