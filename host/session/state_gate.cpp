// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/state_gate.hpp"

#include <algorithm>

#include "firmware/haptable_model.h"

namespace haptable {

namespace {

constexpr std::chrono::microseconds kSilence{HAPTABLE_SILENCE_US};
// A device in lockstep asks again ten times a second: after this it has gone.
constexpr std::chrono::seconds kGone{1};

bool is_clear(const device_state& state) {
    const bool has_mode = state.mode == device_state::REAL_TIME || state.mode == device_state::SIMULATED;
    return has_mode && state.session != 0 && state.seq >= 0;
}

}  // namespace

bool StateGate::is_owned(Clock::time_point now) const { return now < owned_until(); }

Clock::time_point StateGate::owned_until() const {
    if (!has_states_) return heard_;
    return is_simulated(state_) ? heard_ + kGone : heard_ + kSilence;
}

StateIs StateGate::judge(const device_state& state, std::int64_t received_utime, Clock::time_point now) {
    const auto refuse = [](std::int64_t& counter) {
        ++counter;
        return StateIs::refused;
    };
    if (state.model_hash != 0 && state.model_hash != model_hash_) return refuse(counters_.foreign_states);
    if (!is_clear(state)) return refuse(counters_.odd_states);
    if (state.servo != 0 && state.servo != servo_) return refuse(counters_.other_servo_states);
    if (!is_simulated(state) && utime_now() - received_utime >= kSilence.count()) return refuse(counters_.late_states);
    const bool same = has_states_ && state.session == state_.session;
    if (!same && is_owned(now)) {
        ++counters_.other_device_states;
        return StateIs::others;
    }
    if (!same) {
        gaps_.begin();
        return keep(state, StateIs::beginning, now);
    }
    // Silence is forgotten with all that was before it. Simulated time stood still meanwhile.
    if (!is_simulated(state_) && !is_owned(now)) return keep(state, StateIs::beginning, now);
    const StateIs next = judge_next(state);
    if (next == StateIs::repeated && is_simulated(state)) heard_ = now;
    return next == StateIs::next || next == StateIs::beginning ? keep(state, next, now) : next;
}

/// A state of the device that has the servo.
StateIs StateGate::judge_next(const device_state& state) {
    if (state.mode != state_.mode) {
        ++counters_.odd_states;
        return StateIs::refused;
    }
    if (is_last_one(state)) {
        ++counters_.repeated_states;
        return StateIs::repeated;
    }
    if (state.seq <= state_.seq) {
        ++counters_.old_states;
        return StateIs::refused;
    }
    if (state.utime <= state_.utime) {
        ++counters_.stopped_states;
        return StateIs::refused;
    }
    // A device that belonged to this servo and asks any again has heard nothing of it, and has let go.
    return state.servo == 0 && state_.servo != 0 ? StateIs::beginning : StateIs::next;
}

StateIs StateGate::keep(const device_state& state, StateIs as, Clock::time_point now) {
    gaps_.note(state.seq);
    state_ = state;
    heard_ = now;
    has_states_ = true;
    return as;
}

bool StateGate::is_last_one(const device_state& state) const {
    // Bit for bit but for the servo's name, which the device may have learnt meanwhile: NaN is what it was, too.
    const auto same = [](const double a[3], const double b[3]) {
        return std::equal(a, a + 3, b, [](double x, double y) { return x == y || (x != x && y != y); });
    };
    return state.seq == state_.seq && state.utime == state_.utime && state.buttons == state_.buttons &&
           same(state.position_m, state_.position_m) && same(state.velocity_m_s, state_.velocity_m_s);
}

StateCounters StateGate::counters() const {
    StateCounters counters = counters_;
    counters.lost_states = gaps_.lost();
    return counters;
}

}  // namespace haptable
