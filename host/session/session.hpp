// SPDX-License-Identifier: GPL-2.0-or-later
// device_state in, servo_force and contact out: a servo as the partner of a device over LCM, or of one for each finger.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/base/summary_lines.hpp"
#include "host/link/clock.hpp"
#include "host/link/connection.hpp"
#include "host/link/live_state.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/session/answer.hpp"
#include "host/session/counted.hpp"
#include "host/session/record.hpp"
#include "host/session/state_gate.hpp"
#include "host/session/stepper.hpp"

namespace haptable {

/// What the link counts of a finger beside the stepper's own counters.
struct LinkReport : LinkCounters {
    DurationStatistics latency;  ///< from the arrival of a state to its answer
};

/// Answers its devices' states, of several that wait in real time the newest alone. Of two fingers a tick is both: a
/// state waits for the other's, in real time for a millisecond. Single-threaded: everything happens within
/// connection.handle_until and the calls below, so the same code runs against a device in another process and, over
/// memq://, in this one.
class Session {
public:
    /// Subscribes to states. `record` may be null. `tell` gets a line for each event, if it is there.
    Session(Stepper& stepper, Connection& connection, ServoRecord* record, LiveState::Tell tell = {});
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Takes what the stepper has ready. Throws what it throws, as of a target that runs another scene.
    void take_answers();
    /// The watchdog: after HAPTABLE_SILENCE_US without a state it drops the contact and publishes zero force, once; and
    /// steps who has waited for the other finger. Simulated time stands still between states, so in lockstep there is
    /// no silence, but for a finger whose device is gone while the other waits.
    void watch(Clock::time_point now);
    /// When watch has work again. Far away while there is nothing to watch.
    Clock::time_point watch_at() const;
    /// Publishes servo_status and begins a new count of the longest tick.
    void publish_status();

    bool has_states() const;
    /// When a device's last state came; begin of the session before.
    Clock::time_point last_state() const;
    LinkReport link_report(std::size_t finger = 0) const;

private:
    /// A finger's device and its states.
    struct Side {
        explicit Side(const StateGate& of) : gate(of) {}

        StateGate gate;
        bool waits = false;                 ///< the gate's state is not stepped yet
        bool begins = false;                ///< it, or one that it overtook, is a session's first
        bool is_late = false;               ///< the other has waited for it in vain: it is not waited for again
        bool is_asked = false;              ///< `state` is to be answered by the tick under way
        Clock::time_point waits_since{};    ///< since the first that it stands for
        std::int64_t received_utime = 0;    ///< of the state that waits, or was asked last
        device_state state{};               ///< the last one that was asked
        std::int64_t asked_utime = 0;       ///< when that one was received
        std::int64_t clock_us = 0;          ///< simulated: the servo's time less the device's
        std::int64_t answered_utime = 0;    ///< of the last answer
        std::int64_t rejected = 0;          ///< positions that the servo does not take
        std::array<float, 3> rejected_m{};  ///< the last one
        LinkReport link;
    };

    void subscribe(std::size_t finger);
    void on_pose(const hand_pose& pose);
    const hand_pose* pose_of(const device_state& state) const;
    void on_state(std::size_t finger, const device_state& state, std::int64_t received_utime);
    bool is_mode_of_others(std::size_t finger, const device_state& state) const;
    bool is_there(std::size_t finger, Clock::time_point now) const;
    bool is_ready(Clock::time_point now) const;
    void step_if_ready();
    void step(Clock::time_point now);
    TickRequest take_states(Clock::time_point now);
    std::uint32_t time_of_tick(Clock::time_point now);
    void set_time(std::int64_t utime);
    void end_waiting();
    void finish();
    void publish_forces();
    void publish_force(const device_state& state, std::size_t finger, std::int64_t utime);
    void publish_motion();
    void note_rejected();
    Clock::time_point silent_at(std::size_t finger) const;
    void watch(std::size_t finger, Clock::time_point now);
    std::string who(std::size_t finger) const;
    void tell();

    Stepper& stepper_;
    Connection& connection_;
    ServoRecord* record_;
    Answer answer_;
    std::vector<Side> side_;
    std::vector<hand_pose> poses_;  ///< of a tool: the newest, each at seq modulo their number
    FingerInputs in_;               ///< the tick under way, or the last one
    TickNumbers numbers_;           ///< of two fingers' ticks, in the record
    std::int64_t tick_number_ = 0;  ///< the same, of that tick
    std::int64_t tick_utime_ = 0;   ///< of its answers
    double longest_us_ = 0.0;
    LiveState live_;
};

/// A finger's counters and latency, at the end of a run. suffix: of the finger, at the end of each name.
void add_link_report(const LinkReport& link, const std::string& suffix, SummaryLines& summary);

}  // namespace haptable
