// SPDX-License-Identifier: GPL-2.0-or-later
// Which of the states that come are ticks of a servo: it belongs to one device at a time, and its time runs.
#pragma once

#include "host/link/clock.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/session/counted.hpp"

namespace haptable {

/// What a state is to the servo that it came to.
enum class StateIs {
    next,       ///< the next tick of the servo's device
    beginning,  ///< the same, but the device has begun anew: there is no contact from before
    repeated,   ///< the last one once more: the same answer belongs to it
    others,     ///< of another device than the servo's: it is told so
    refused     ///< counted, and nothing else
};

/// A device has the servo from its first state until it is silent: for 20 ms in real time. In lockstep a second of real
/// time, after which another device may take it; the same device goes on, whenever it does.
class StateGate {
public:
    /// `servo` and `model_hash` as in the servo's messages.
    StateGate(std::int64_t servo, std::int64_t model_hash) : servo_(servo), model_hash_(model_hash) {}

    /// Judges, counts, and keeps what is a tick. `received_utime`: when it came to this machine.
    StateIs judge(const device_state& state, std::int64_t received_utime, Clock::time_point now);
    void count_skipped() { ++counters_.skipped_states; }
    void count_odd() { ++counters_.odd_states; }
    void count_poseless() { ++counters_.poseless_states; }
    void count_absent_finger() { ++counters_.absent_finger_states; }

    bool has_states() const { return has_states_; }
    /// The last tick's.
    const device_state& state() const { return state_; }
    /// When the last tick came; before there was one, the begin.
    Clock::time_point last_state() const { return heard_; }
    /// A device has the servo.
    bool is_owned(Clock::time_point now) const;
    /// Until when, should no state come. Where there was none: the begin.
    Clock::time_point owned_until() const;
    /// session of the device that has the servo; 0: none.
    std::int64_t owner(Clock::time_point now) const { return is_owned(now) ? state_.session : 0; }
    StateCounters counters() const;

private:
    StateIs judge_next(const device_state& state);
    StateIs keep(const device_state& state, StateIs as, Clock::time_point now);
    bool is_last_one(const device_state& state) const;

    std::int64_t servo_, model_hash_;
    device_state state_{};
    bool has_states_ = false;
    Clock::time_point heard_ = Clock::now();
    SequenceGaps gaps_;
    StateCounters counters_;
};

}  // namespace haptable
