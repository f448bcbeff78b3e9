// SPDX-License-Identifier: GPL-2.0-or-later
// state -> the device's? -> the other finger's, too? -> step -> forces published -> contacts published -> recorded
#include "host/servo/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/session/pose_message.hpp"
#include "host/session/status.hpp"
#include "host/session/tell.hpp"

namespace haptable {

namespace {

// Of the tables, after each answer: the cube's are gone through in half a second, and a tick is not felt to be longer.
constexpr std::uint32_t kIdleCheck_bytes = HAPTABLE_CHECK_BYTES;

static_assert(kTick == std::chrono::microseconds(HAPTABLE_TICK_US));
static_assert(kFingers == HAPTABLE_FINGERS);

}  // namespace

ServoSession::ServoSession(const ServoScene& scene, Connection& connection, ServoRecord* record, LiveState::Tell tell)
    : scene_(scene),
      connection_(connection),
      record_(record),
      answer_(scene, connection),
      fingers_(scene),
      live_(std::move(tell)) {
    for (std::size_t finger = 0; finger < fingers_.count(); ++finger)
        side_.emplace_back(StateGate(answer_.servo(), answer_.model_hash()));
    for (std::size_t finger = 0; finger < kFingers; ++finger) subscribe(finger);
    connection.after_all([this] { step_if_ready(); });
}

void ServoSession::subscribe(std::size_t finger) {
    connection_.subscribe<device_state>(channel_of<device_state>(finger),
                                        [this, finger](const device_state& state, std::int64_t received_utime) {
                                            if (finger < side_.size()) return on_state(finger, state, received_utime);
                                            side_[0].gate.count_absent_finger();
                                        });
}

// ---- a state comes ------------------------------------------------------------------------------------------------

void ServoSession::on_state(std::size_t finger, const device_state& state, std::int64_t received_utime) {
    Side& side = side_[finger];
    const bool waited = side.waits;
    const Clock::time_point now = Clock::now();
    if (is_of_other_time(finger, state)) return side.gate.count_odd();
    switch (side.gate.judge(state, received_utime, now)) {
        case StateIs::refused:
            return;
        case StateIs::others:
            return answer_.refuse(state, side.gate.state().session, finger);
        case StateIs::repeated:
            // The device did not get our answer: the same again, so that a lost message changes no result.
            if (!side.waits)
                answer_.publish_force(side.gate.state(), fingers_.output(finger), side.answered_utime, finger);
            return step_if_ready();
        case StateIs::beginning:
            side.begins = true;
            side.clock_us = 0;
            // A clock of its own: it goes on from where the other finger's is.
            for (std::size_t other = 0; other < side_.size(); ++other)
                if (other != finger && is_there(other, now)) side.clock_us = tick_utime_ - state.utime;
            break;
        case StateIs::next:
            break;
    }
    if (waited) side.gate.count_skipped();
    if (!waited) side.waits_since = now;
    side.waits = true;
    side.is_late = false;
    side.received_utime = received_utime;
    side.at_m = to_finger(state.position_m);
    // Simulated time knows no hurry, and every one of its ticks counts.
    if (is_simulated(state)) step_if_ready();
}

/// One finger in lockstep and the other in real time have no tick in common.
bool ServoSession::is_of_other_time(std::size_t finger, const device_state& state) const {
    const Clock::time_point now = Clock::now();
    for (std::size_t other = 0; other < side_.size(); ++other)
        if (other != finger && is_there(other, now) && state.mode != side_[other].gate.state().mode) return true;
    return false;
}

bool ServoSession::is_there(std::size_t finger, Clock::time_point now) const {
    return side_[finger].waits || side_[finger].gate.is_owned(now);
}

// ---- a tick -------------------------------------------------------------------------------------------------------

/// A state waits for that of the other finger, in real time for a tick at the most. Who begins is not waited for, and
/// does not wait: so two devices of one program join the same ticks in each of its sessions.
bool ServoSession::is_ready(Clock::time_point now) const {
    bool waits = false, is_missing = false;
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        waits |= side.waits;
        is_missing |= is_there(finger, now) && !side.waits && !side.is_late;
        if (side.waits && side.begins) return true;
        if (side.waits && !is_simulated(side.gate.state()) && now - side.waits_since >= kTick) return true;
    }
    return waits && !is_missing;
}

void ServoSession::step_if_ready() {
    const Clock::time_point now = Clock::now();
    if (is_ready(now)) step(now);
}

void ServoSession::step(Clock::time_point now) {
    const std::size_t lead = leading();
    const device_state& state = side_[lead].gate.state();
    const FingerInputs in = inputs(now);
    const std::int64_t number = side_.size() == 1 ? state.seq : numbers_.next(fingers_.is_anew(in));
    // Simulated time is the message's, real time is this machine's: the device's clock may be another one.
    const bool simulated = is_simulated(state);
    if (simulated) set_time(state.utime + side_[lead].clock_us);
    fingers_.tick(in, simulated ? static_cast<std::uint32_t>(tick_utime_) : to_firmware_us(Clock::now()));
    longest_step_us_ = std::max(longest_step_us_, fingers_.step_us());
    if (!simulated) set_time(utime_now());
    answer(lead);
    fingers_.check(kIdleCheck_bytes);
    record(in, number);
    end_tick(in);
}

/// Answers of two fingers with one time are one tick, so that no other has it.
void ServoSession::set_time(std::int64_t utime) {
    tick_utime_ = side_.size() == 2 && utime == tick_utime_ ? utime + 1 : utime;
}

/// Of the fingers whose state waits the first, whose time the tick has.
std::size_t ServoSession::leading() const {
    return static_cast<std::size_t>(
        std::find_if(side_.begin(), side_.end(), [](const Side& side) { return side.waits; }) - side_.begin());
}

/// A finger whose state did not come is where it was.
FingerInputs ServoSession::inputs(Clock::time_point now) const {
    FingerInputs in;
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        if (is_there(finger, now))
            in[finger] = FingerInput{side.at_m, buttons_of(side.gate.state()), side.waits && side.begins};
    }
    return in;
}

void ServoSession::answer(std::size_t lead) {
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (!side.waits) continue;
        answer_.publish_force(side.gate.state(), fingers_.output(finger), tick_utime_, finger);
        side.answered_utime = tick_utime_;
        const auto latency_us = static_cast<double>(utime_now() - side.received_utime);
        side.link.latency.add(latency_us);
        if (latency_us > static_cast<double>(kTick.count())) ++side.link.late_ticks;
    }
    const SceneState& state = fingers_.state();
    const auto of = [&](auto message) {
        return addressed(message, side_[lead].gate.state(), tick_utime_, answer_.servo(), *scene_.model);
    };
    if (scene_.body != nullptr)
        connection_.publish(channel_of<body_pose>(), of(to_pose_message(*scene_.body, *state.touched())));
    if (scene_.modes != nullptr)
        connection_.publish(channel_of<body_modes>(), of(to_modes_message(*scene_.modes, *state.modes())));
    for (std::size_t finger = 0; finger < side_.size(); ++finger)
        if (side_[finger].waits) answer_.publish_contact(side_[finger].gate.state(), fingers_.output(finger), finger);
}

void ServoSession::record(const FingerInputs& in, std::int64_t number) {
    if (record_ == nullptr) return;
    if (side_.size() == 1)
        return record_->add(number, in[0]->at_m, in[0]->buttons, fingers_.output(0), fingers_.state().touched(),
                            fingers_.state().modes());
    record_->add(number, in, fingers_);
}

void ServoSession::end_tick(const FingerInputs& in) {
    const bool joins = std::any_of(side_.begin(), side_.end(), [](const Side& side) { return side.begins; });
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (fingers_.output(finger).state == HAPTABLE_REJECTED) side.rejected_m = side.at_m;
        if (!side.waits && !joins) side.is_late = in[finger].has_value();
    }
    for (Side& side : side_) side.waits = side.begins = false;
}

// ---- none comes ---------------------------------------------------------------------------------------------------

/// When a finger falls silent. In lockstep time stands still, but a device that is gone does not hold up the other's.
Clock::time_point ServoSession::silent_at(std::size_t finger) const {
    const Side& side = side_[finger];
    if (fingers_.servo(finger).state == HAPTABLE_SILENT) return Clock::time_point::max();
    if (!is_simulated(side.gate.state()))
        return side.gate.last_state() + std::chrono::microseconds(HAPTABLE_SILENCE_US);
    const bool other_waits = std::any_of(side_.begin(), side_.end(), [](const Side& any) { return any.waits; });
    return other_waits && !side.waits ? side.gate.owned_until() : Clock::time_point::max();
}

Clock::time_point ServoSession::watch_at() const {
    Clock::time_point at = Clock::time_point::max();
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        at = std::min(at, silent_at(finger));
        if (side.waits && !is_simulated(side.gate.state())) at = std::min(at, side.waits_since + kTick);
    }
    return at;
}

void ServoSession::watch(Clock::time_point now) {
    for (std::size_t finger = 0; finger < side_.size(); ++finger) watch(finger, now);
    if (is_ready(now)) step(now);
}

void ServoSession::watch(std::size_t finger, Clock::time_point now) {
    Side& side = side_[finger];
    const bool touched = haptable_touches(fingers_.output(finger).state) != 0;
    if (now < silent_at(finger) || !fingers_.release(finger)) return;
    const device_state& state = side.gate.state();
    if (touched) live_.say(who(finger) + contact_dropped_after(now - side.gate.last_state()));
    const std::int64_t utime = is_simulated(state) ? tick_utime_ : utime_now();
    answer_.publish_force(state, fingers_.output(finger), utime, finger);
    answer_.publish_contact(state, fingers_.output(finger), finger);
}

// ---- what is told -------------------------------------------------------------------------------------------------

void ServoSession::publish_status() {
    const Clock::time_point now = Clock::now();
    Status status(answer_, side_[0].gate.owner(now), fingers_.output(0), longest_step_us_);
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const std::string suffix = kFingerSuffix[finger];
        if (finger > 0) {
            status("session" + suffix, side_[finger].gate.owner(now));
            status("servo_state" + suffix, fingers_.output(finger).state);
            status("faults" + suffix, fingers_.output(finger).faults);
        }
#define HAPTABLE_ADD(name) status(#name + suffix, fingers_.servo(finger).counters.name);
        HAPTABLE_COUNTERS(HAPTABLE_ADD)
#undef HAPTABLE_ADD
        status.add(fingers_.report(finger), suffix);
        link_report(finger).each([&](const char* name, std::int64_t value) { status(name + suffix, value); });
    }
    status.publish(connection_);
    if (record_ != nullptr) record_->flush();
    longest_step_us_ = 0.0;
    tell();
}

void ServoSession::tell() {
    const Clock::time_point now = Clock::now();
    for (std::size_t finger = 0; finger < side_.size(); ++finger) tell(finger, now);
}

/// Of two fingers, which one a line is about.
std::string ServoSession::who(std::size_t finger) const {
    return side_.size() == 1 ? "" : "finger " + std::to_string(finger + 1) + ": ";
}

void ServoSession::tell(std::size_t finger, Clock::time_point now) {
    const std::string of = who(finger);
    tell_of_states(side_[finger].gate.counters(), now, live_, of);
    const haptable_counters& counters = fingers_.servo(finger).counters;
    live_.look(of + "rejected", std::int64_t{counters.rejected_positions} + counters.implausible, now,
               [&] { return of + why_rejected(*scene_.model, side_[finger].rejected_m); });
}

bool ServoSession::has_states() const {
    return std::any_of(side_.begin(), side_.end(), [](const Side& side) { return side.gate.has_states(); });
}

Clock::time_point ServoSession::last_state() const {
    Clock::time_point last = side_[0].gate.last_state();
    for (const Side& side : side_)
        if (side.gate.has_states()) last = std::max(last, side.gate.last_state());
    return last;
}

LinkReport ServoSession::link_report(std::size_t finger) const {
    LinkReport link = side_[finger].link;
    static_cast<StateCounters&>(link) = side_[finger].gate.counters();
    return link;
}

}  // namespace haptable
