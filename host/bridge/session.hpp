// SPDX-License-Identifier: GPL-2.0-or-later
// device_state in, a frame out; a frame in, servo_force and contact out: a target as the servo of a device over LCM.
#pragma once

#include "host/bridge/target.hpp"
#include "host/link/connection.hpp"
#include "host/link/live_state.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/session/answer.hpp"
#include "host/session/counted.hpp"
#include "host/session/energy.hpp"
#include "host/session/record.hpp"
#include "host/session/scene.hpp"
#include "host/session/state_gate.hpp"

namespace haptable {

struct BridgeOptions {
    std::chrono::microseconds retry{50'000};  ///< a state without an answer is sent again after this
    double patience_s = 10.0;                 ///< without any answer for so long, the target is gone
};

struct BridgeReport : ForceReport, BridgeCounters {
    DurationStatistics round_trip;  ///< from a state's first frame to its answer
};

/// Takes states as ServoSession does, and is single-threaded like it: everything happens within connection.handle_until
/// and the calls below.
class BridgeSession {
public:
    /// Subscribes to the device's states. `record` may be null. `tell` gets a line for each event, if it is there.
    BridgeSession(const ServoScene& scene, Connection& connection, SerialTarget& target, const BridgeOptions& options,
                  ServoRecord* record, LiveState::Tell tell = {});
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

    bool has_states() const { return gate_.has_states(); }
    Clock::time_point last_state() const { return gate_.last_state(); }
    BridgeReport report() const;

private:
    void on_state(const device_state& state, std::int64_t received_utime);
    void ask();
    void send();
    void take(const TargetForce& force);
    bool is_possible(const haptable_output& output) const;
    bool is_on_a_patch(const haptable_output& output) const;
    void note(const haptable_output& output, Clock::time_point now);
    void tell();

    ServoScene scene_;
    Connection& connection_;
    SerialTarget& target_;
    BridgeOptions options_;
    ServoRecord* record_;
    Answer answer_;
    StateGate gate_;
    haptable_output output_{};
    device_state state_{};                      ///< the last one that the target was asked
    haptable_frame_state asked_{};              ///< as the target gets it
    std::uint32_t clock_us_ = 0;                ///< from a state's time to the target's
    std::uint32_t number_ = 0;                  ///< of that frame; counts on over sessions of devices
    bool to_ask_ = false;                       ///< the gate's state was not sent yet
    bool begins_ = false;                       ///< it, or one that it overtook, is a session's first
    bool waiting_ = false;                      ///< for an answer
    Clock::time_point first_sent_, last_sent_;  ///< that frame
    Clock::time_point deaf_since_;              ///< the first state that was not answered since the last answer
    BridgeReport report_;
    double longest_us_ = 0.0;
    LiveState live_;
    std::int64_t rejected_ = 0;          ///< positions that the target does not take
    std::array<float, 3> rejected_m_{};  ///< the last one
};

}  // namespace haptable
