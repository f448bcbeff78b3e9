// SPDX-License-Identifier: GPL-2.0-or-later
// device_state in, a frame out; a frame in, servo_force and contact out: a target as the servo of a device over LCM.
#pragma once

#include "host/bridge/target.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/servo/answer.hpp"
#include "host/servo/energy.hpp"
#include "host/servo/record.hpp"
#include "host/servo/scene.hpp"

namespace haptable {

struct BridgeOptions {
    std::chrono::microseconds retry{50'000};  ///< a state without an answer is sent again after this
    double patience_s = 10.0;                 ///< without any answer for so long, the target is gone
};

struct BridgeReport : ForceReport {
    std::int64_t ticks = 0;            ///< forces that answered a state
    std::int64_t contact_ticks = 0;    ///< of these, with contact
    std::int64_t lost_states = 0;      ///< gaps in the device's numbering
    std::int64_t repeated_states = 0;  ///< asked again by the device
    std::int64_t foreign_states = 0;   ///< meant for another model: not sent on
    std::int64_t resent_frames = 0;    ///< states sent again because no answer came
    std::int64_t lost_answers = 0;     ///< states that the device's next one overtook: never answered
    std::int64_t stale_answers = 0;    ///< to a state that was answered or overtaken before
    std::int64_t skipped_bytes = 0;    ///< of the line, that belonged to no frame
    std::int64_t foreign_frames = 0;   ///< whole, but not forces
    std::int64_t rejected_forces = 0;  ///< that no servo of these tables gives: not published
    DurationStatistics round_trip;     ///< from a state's first frame to its answer
};

/// Single-threaded, like ServoSession: everything happens within connection.handle_until and the calls below.
class BridgeSession {
public:
    /// Subscribes to the device's states. `record` may be null.
    BridgeSession(const ServoScene& scene, Connection& connection, Target& target, const BridgeOptions& options,
                  ServoRecord* record);
    BridgeSession(const BridgeSession&) = delete;
    BridgeSession& operator=(const BridgeSession&) = delete;

    /// Takes what the line has brought. Throws Error when the target runs other tables.
    void take_answers();
    /// Asks again for an answer that has not come, publishes zero force once when the device has fallen silent.
    /// Throws Error when the target has not answered for patience_s.
    void watch(Clock::time_point now);
    /// When watch has work again.
    Clock::time_point watch_at() const;
    void publish_status();

    bool has_states() const { return has_states_; }
    Clock::time_point last_state() const { return last_state_; }
    BridgeReport report() const;

private:
    void on_state(const device_state& state);
    void ask(const device_state& state);
    void send();
    void take(const TargetForce& force);
    bool is_possible(const haptable_output& output) const;
    void note(const haptable_output& output, Clock::time_point now);

    ServoScene scene_;
    Connection& connection_;
    Target& target_;
    BridgeOptions options_;
    ServoRecord* record_;
    Answer answer_;
    haptable_output output_{};
    device_state state_{};          ///< the last one
    haptable_frame_state asked_{};  ///< as the target gets it
    std::uint32_t number_ = 0;      ///< of that frame; counts on over sessions of devices
    bool waiting_ = false;          ///< for its answer
    bool has_states_ = false;
    Clock::time_point last_state_ = Clock::now();
    Clock::time_point first_sent_, last_sent_;  ///< that frame
    Clock::time_point deaf_since_;              ///< the first state that was not answered since the last answer
    SequenceGaps gaps_;
    BridgeReport report_;
    double longest_us_ = 0.0;
};

}  // namespace haptable
