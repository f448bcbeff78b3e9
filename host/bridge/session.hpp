// SPDX-License-Identifier: GPL-2.0-or-later
// device_state in, a frame out; a frame in, servo_force and contact out: a target as the servo of a device over LCM, or
// of one for each finger.
#pragma once

#include <string>
#include <vector>

#include "host/bridge/target.hpp"
#include "host/link/connection.hpp"
#include "host/link/live_state.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/session/answer.hpp"
#include "host/session/counted.hpp"
#include "host/session/energy.hpp"
#include "host/session/fingers.hpp"
#include "host/session/record.hpp"
#include "host/session/scene.hpp"
#include "host/session/state_gate.hpp"

namespace haptable {

struct BridgeOptions {
    std::chrono::microseconds retry{50'000};  ///< a state without an answer is sent again after this
    std::chrono::microseconds hold{2000};     ///< so long at least no newer state overtakes one in real time
    double patience_s = 10.0;                 ///< without any answer for so long, the target is gone
};

struct BridgeReport : ForceReport, BridgeCounters {
    DurationStatistics round_trip;  ///< from a tick's first frame to its answer; of two fingers with the first

    /// Those of a second finger: visit(name, value). The line's own are the first's.
    template <typename Visit>
    void each_of_second(Visit&& visit) const {
        StateCounters::each(visit);
        visit("ticks", ticks);
        visit("contact_ticks", contact_ticks);
        visit("lost_answers", lost_answers);
    }
};

/// Takes states as ServoSession does, and is single-threaded like it: everything happens within connection.handle_until
/// and the calls below. Before the first tick the target says what it is. Of two fingers a tick is both: it waits for
/// the other's state as ServoSession does, and sends the target both.
class BridgeSession {
public:
    /// Subscribes to states. `record` may be null. `tell` gets a line for each event, if it is there.
    BridgeSession(const ServoScene& scene, Connection& connection, SerialTarget& target, const BridgeOptions& options,
                  ServoRecord* record, LiveState::Tell tell = {});
    BridgeSession(const BridgeSession&) = delete;
    BridgeSession& operator=(const BridgeSession&) = delete;

    /// Takes what the line has brought. Throws Error when the target runs another scene, or speaks another version.
    void take_answers();
    /// Asks again for an answer that has not come, asks for who has waited for the other finger, publishes zero force
    /// once when a device has fallen silent. Throws Error when the target has not answered for patience_s.
    void watch(Clock::time_point now);
    /// When watch has work again.
    Clock::time_point watch_at() const;
    void publish_status();

    bool has_states() const;
    Clock::time_point last_state() const;
    std::size_t finger_count() const { return side_.size(); }
    BridgeReport report(std::size_t finger = 0) const;
    /// Energy given to the hands together, the largest so far, J.
    double most_given_j() const { return most_given_j_; }

private:
    /// A finger's device and what waits of it.
    struct Side {
        explicit Side(const StateGate& of) : gate(of) {}

        StateGate gate;
        bool waits = false;                 ///< the gate's state was not sent yet
        bool begins = false;                ///< it, or one that it overtook, is a session's first
        bool is_late = false;               ///< the other has waited for it in vain: it is not waited for again
        bool is_asked = false;              ///< `state` is to be answered
        Clock::time_point waits_since{};    ///< since the first that it stands for
        device_state state{};               ///< the last one that the target was asked
        std::int64_t clock_us = 0;          ///< simulated: the servo's time less the device's
        std::int64_t answered_utime = 0;    ///< of the last answer
        haptable_output output{};           ///< of the last tick
        std::int64_t rejected = 0;          ///< positions that the target does not take
        std::array<float, 3> rejected_m{};  ///< the last one
        BridgeReport report;
    };

    void subscribe(std::size_t finger);
    void on_state(std::size_t finger, const device_state& state, std::int64_t received_utime);
    bool is_of_other_time(std::size_t finger, const device_state& state) const;
    bool is_there(std::size_t finger, Clock::time_point now) const;
    bool is_ready(Clock::time_point now) const;
    void ask_if_ready();
    void ask(Clock::time_point now);
    void set_time(std::int64_t utime);
    void take_states(Clock::time_point now);
    std::uint32_t time_of_tick(Clock::time_point now);
    void make_frame(std::uint32_t time_us);
    void end_asking();
    void send();
    void take(const TargetHello& hello);
    void take(const TargetAnswer& answer);
    void finish(const TargetAnswer& answer);
    void publish_forces();
    void publish_motion();
    const haptable_body_state* pose() const { return scene_.body != nullptr ? &pose_ : nullptr; }
    const haptable_modes_state* modes() const { return scene_.modes != nullptr ? &modes_ : nullptr; }
    std::array<float, 3> inside(const std::array<float, 3>& world_m) const;
    void record();
    bool is_possible(const haptable_output& output) const;
    bool is_possible(const TargetAnswer& answer) const;
    static bool rises_within(double most_n, const float force_n[3], const float before_n[3]);
    static bool is_possible(const haptable_body_state& body);
    bool is_on_a_patch(const haptable_output& output) const;
    void note(Clock::time_point now);
    void note(std::size_t finger);
    Clock::time_point silent_at(std::size_t finger) const;
    void watch(std::size_t finger, Clock::time_point now);
    std::string who(std::size_t finger) const;
    void tell();
    void tell(std::size_t finger, Clock::time_point now);

    ServoScene scene_;
    Connection& connection_;
    SerialTarget& target_;
    BridgeOptions options_;
    ServoRecord* record_;
    Answer answer_;
    haptable_body_state pose_{};    ///< of the last tick, as the line has it
    haptable_modes_state modes_{};  ///< likewise
    std::vector<Side> side_;
    FingerInputs in_;                           ///< the tick under way, or the last one
    haptable_line_state frame_{};               ///< as the target gets it
    TickNumbers numbers_;                       ///< of two fingers' ticks, in the record
    std::int64_t tick_number_ = 0;              ///< the same, of that tick
    std::int64_t tick_utime_ = 0;               ///< of its answers
    std::uint32_t sent_us_ = 0;                 ///< its time, for the target
    std::uint32_t clock_us_ = 0;                ///< from a state's time to the target's
    std::uint32_t number_ = 0;                  ///< of its frames; counts on over sessions of devices
    std::uint32_t answered_ = 0;                ///< the last one that was published
    bool waiting_ = false;                      ///< for its answer
    Clock::duration hold_;                      ///< so long no newer state overtakes it in real time
    Clock::time_point first_sent_, last_sent_;  ///< its frames
    Clock::time_point deaf_since_;              ///< the first state that was not answered since the last answer
    bool is_known_ = false;                     ///< the target has said what it is
    double longest_us_ = 0.0, most_given_j_ = 0.0;
    LiveState live_;
};

}  // namespace haptable
