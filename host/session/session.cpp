// SPDX-License-Identifier: GPL-2.0-or-later
// state -> the device's? -> the other finger's, too? -> step -> forces published -> contacts published -> recorded
#include "host/session/session.hpp"

#include <algorithm>
#include <utility>

#include "host/session/pose_message.hpp"
#include "host/session/status.hpp"
#include "host/session/tell.hpp"

namespace haptable {

namespace {

constexpr std::size_t kPoses = 64;  // ms that a state may be behind its pose

}  // namespace

Session::Session(Stepper& stepper, Connection& connection, ServoRecord* record, LiveState::Tell tell)
    : stepper_(stepper),
      connection_(connection),
      record_(record),
      answer_(stepper.scene(), connection),
      live_(std::move(tell)) {
    for (std::size_t finger = 0; finger < stepper.finger_count(); ++finger)
        side_.emplace_back(StateGate(answer_.servo(), answer_.model_hash()));
    for (std::size_t finger = 0; finger < kFingers; ++finger) subscribe(finger);
    if (stepper.tool() != nullptr) {
        poses_.resize(kPoses);
        connection.subscribe<hand_pose>(channel_of<hand_pose>(),
                                        [this](const hand_pose& pose, std::int64_t) { on_pose(pose); });
    }
    connection.after_all([this] { step_if_ready(); });
}

void Session::subscribe(std::size_t finger) {
    connection_.subscribe<device_state>(channel_of<device_state>(finger),
                                        [this, finger](const device_state& state, std::int64_t received_utime) {
                                            if (finger < side_.size()) return on_state(finger, state, received_utime);
                                            side_[0].gate.count_absent_finger();
                                        });
}

// ---- a state comes ------------------------------------------------------------------------------------------------

void Session::on_pose(const hand_pose& pose) {
    if (pose.seq >= 0) poses_[static_cast<std::size_t>(pose.seq) % poses_.size()] = pose;
}

/// How the hand holds its tool; null: that was not heard.
const hand_pose* Session::pose_of(const device_state& state) const {
    if (state.seq < 0 || poses_.empty()) return nullptr;
    const hand_pose& pose = poses_[static_cast<std::size_t>(state.seq) % poses_.size()];
    return pose.seq == state.seq && pose.session == state.session ? &pose : nullptr;
}

void Session::on_state(std::size_t finger, const device_state& state, std::int64_t received_utime) {
    Side& side = side_[finger];
    const bool waited = side.waits;
    const Clock::time_point now = Clock::now();
    if (is_mode_of_others(finger, state)) return side.gate.count_odd();
    if (!poses_.empty() && pose_of(state) == nullptr) return side.gate.count_poseless();
    switch (side.gate.judge(state, received_utime, now)) {
        case StateIs::refused:
            return;
        case StateIs::others:
            return answer_.refuse(state, side.gate.state().session, finger);
        case StateIs::repeated:
            // The device did not get our answer: the same again, so that a lost message changes no result.
            if (!side.is_asked && !side.waits) publish_force(side.state, finger, side.answered_utime);
            return step_if_ready();
        case StateIs::beginning:
            side.begins = true;
            side.clock_us = 0;
            // A clock of its own: it goes on from where the others' is.
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
    // Simulated time knows no hurry, and every one of its ticks counts.
    if (is_simulated(state)) step_if_ready();
}

/// One finger in lockstep and the other in real time have no tick in common.
bool Session::is_mode_of_others(std::size_t finger, const device_state& state) const {
    const Clock::time_point now = Clock::now();
    for (std::size_t other = 0; other < side_.size(); ++other)
        if (other != finger && is_there(other, now) && state.mode != side_[other].gate.state().mode) return true;
    return false;
}

bool Session::is_there(std::size_t finger, Clock::time_point now) const {
    return side_[finger].waits || side_[finger].gate.is_owned(now);
}

// ---- a tick -------------------------------------------------------------------------------------------------------

/// A state waits for those of the other fingers, in real time for a tick at the most. Who begins is not waited for, and
/// does not wait: so two devices of one program join the same ticks in each of its sessions.
bool Session::is_ready(Clock::time_point now) const {
    bool waits = false, is_missing = false, has_waited = false, is_lockstep = false;
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        waits |= side.waits;
        is_missing |= is_there(finger, now) && !side.waits && !side.is_late;
        if (!side.waits) continue;
        is_lockstep |= is_simulated(side.gate.state());
        has_waited |= side.begins || (!is_simulated(side.gate.state()) && now - side.waits_since >= kTick);
    }
    return now >= stepper_.free_at(is_lockstep) && (has_waited || (waits && !is_missing));
}

void Session::step_if_ready() {
    const Clock::time_point now = Clock::now();
    if (is_ready(now)) step(now);
}

void Session::step(Clock::time_point now) {
    TickRequest request = take_states(now);
    request.time_us = time_of_tick(now);
    end_waiting();
    if (stepper_.begin(request)) finish();
}

void Session::take_answers() {
    while (stepper_.take()) finish();
}

/// States that wait, and where a finger was whose state did not come.
TickRequest Session::take_states(Clock::time_point now) {
    TickRequest request;
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        const bool there = is_there(finger, now);
        if (side.waits) {
            request.is_overtaken[finger] = side.is_asked;
            side.state = side.gate.state();
            side.asked_utime = side.received_utime;
            side.is_asked = true;
        }
        side.is_asked &= there;
        if (there)
            request.in[finger] =
                FingerInput{to_finger(side.state.position_m), buttons_of(side.state), side.waits && side.begins};
        if (const hand_pose* pose = pose_of(side.state); there && pose != nullptr)
            request.in[finger]->turn = to_turn(pose->turn);
    }
    in_ = request.in;
    tick_number_ = side_.size() == 1 ? side_[0].state.seq : numbers_.next(stepper_.is_first_tick(in_));
    return request;
}

/// Simulated time is the message's, of the first finger whose state waits; real time is this machine's: the device's
/// clock may be another one.
std::uint32_t Session::time_of_tick(Clock::time_point now) {
    const Side& lead = *std::find_if(side_.begin(), side_.end(), [](const Side& side) { return side.waits; });
    if (!is_simulated(lead.state)) return to_firmware_us(now);
    set_time(lead.state.utime + lead.clock_us);
    return static_cast<std::uint32_t>(tick_utime_);
}

/// Answers of several fingers with one time are one tick, so that no other has it.
void Session::set_time(std::int64_t utime) {
    tick_utime_ = side_.size() > 1 && utime == tick_utime_ ? utime + 1 : utime;
}

void Session::end_waiting() {
    const bool joins = std::any_of(side_.begin(), side_.end(), [](const Side& side) { return side.begins; });
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (!side.waits && !joins) side.is_late = in_[finger].has_value();
    }
    for (Side& side : side_) side.waits = side.begins = false;
}

void Session::finish() {
    longest_us_ = std::max(longest_us_, stepper_.tick_us());
    publish_forces();
    publish_motion();
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (std::exchange(side.is_asked, false))
            answer_.publish_contact(side.state, stepper_.output(finger), finger, stepper_.tool());
    }
    stepper_.idle();
    note_rejected();
    if (record_ != nullptr)
        record_->add(tick_number_, in_, stepper_.outputs(), stepper_.touched(), stepper_.modes(), stepper_.tool());
    step_if_ready();
}

void Session::publish_forces() {
    if (std::any_of(side_.begin(), side_.end(), [](const Side& s) { return s.is_asked && !is_simulated(s.state); }))
        set_time(utime_now());
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (!side.is_asked) continue;
        publish_force(side.state, finger, tick_utime_);
        side.answered_utime = tick_utime_;
        const auto latency_us = static_cast<double>(utime_now() - side.asked_utime);
        side.link.latency.add(latency_us);
        if (latency_us > static_cast<double>(kTick.count())) ++side.link.late_ticks;
    }
}

/// A tool's torque first: who takes the force has it then.
void Session::publish_force(const device_state& state, std::size_t finger, std::int64_t utime) {
    if (stepper_.tool() != nullptr) answer_.publish_wrench(state, *stepper_.tool(), utime);
    answer_.publish_force(state, stepper_.output(finger), utime, finger);
}

/// For the first finger that is answered.
void Session::publish_motion() {
    const auto lead = std::find_if(side_.begin(), side_.end(), [](const Side& side) { return side.is_asked; });
    if (lead == side_.end()) return;
    const ServoScene& scene = stepper_.scene();
    const auto of = [&](auto message) {
        return addressed(message, lead->state, tick_utime_, answer_.servo(), *scene.model);
    };
    if (scene.body != nullptr)
        connection_.publish(channel_of<body_pose>(), of(to_pose_message(*scene.body, *stepper_.touched())));
    if (scene.modes != nullptr)
        connection_.publish(channel_of<body_modes>(), of(to_modes_message(*scene.modes, *stepper_.modes())));
}

void Session::note_rejected() {
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        if (!in_[finger] || stepper_.output(finger).state != HAPTABLE_REJECTED) continue;
        ++side_[finger].rejected;
        side_[finger].rejected_m = in_[finger]->at_m;
    }
}

// ---- none comes ---------------------------------------------------------------------------------------------------

/// When a finger falls silent. In lockstep time stands still, but a device that is gone does not hold up the other's.
Clock::time_point Session::silent_at(std::size_t finger) const {
    const Side& side = side_[finger];
    if (stepper_.output(finger).state == HAPTABLE_SILENT) return Clock::time_point::max();
    if (!is_simulated(side.gate.state()))
        return side.gate.last_state() + std::chrono::microseconds(HAPTABLE_SILENCE_US);
    const bool other_waits = std::any_of(side_.begin(), side_.end(), [](const Side& any) { return any.waits; });
    return other_waits && !side.waits ? side.gate.owned_until() : Clock::time_point::max();
}

Clock::time_point Session::watch_at() const {
    Clock::time_point at = stepper_.watch_at();
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        at = std::min(at, silent_at(finger));
        if (side.waits && !is_simulated(side.gate.state()))
            at = std::min(at, std::max(side.waits_since + kTick, stepper_.free_at(false)));
    }
    return at;
}

void Session::watch(Clock::time_point now) {
    for (std::size_t finger = 0; finger < side_.size(); ++finger) watch(finger, now);
    if (is_ready(now)) return step(now);
    stepper_.watch(now);
}

void Session::watch(std::size_t finger, Clock::time_point now) {
    Side& side = side_[finger];
    if (now < silent_at(finger)) return;
    if (haptable_touches(stepper_.output(finger).state) != 0)
        live_.say(who(finger) + contact_dropped_after(now - side.gate.last_state()));
    in_[finger].reset();
    side.is_asked = false;
    stepper_.release(finger);
    const device_state& state = side.gate.state();
    side.answered_utime = is_simulated(state) ? tick_utime_ : utime_now();
    publish_force(state, finger, side.answered_utime);
    answer_.publish_contact(state, stepper_.output(finger), finger, stepper_.tool());
}

// ---- what is told -------------------------------------------------------------------------------------------------

void Session::publish_status() {
    const Clock::time_point now = Clock::now();
    Status status(answer_, side_[0].gate.owner(now), stepper_.output(0), longest_us_);
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const std::string suffix = kFingerSuffix[finger];
        const auto add = [&](const char* name, std::int64_t value) { status(name + suffix, value); };
        if (finger > 0) {
            add("session", side_[finger].gate.owner(now));
            add("servo_state", stepper_.output(finger).state);
            add("faults", stepper_.output(finger).faults);
        }
        stepper_.count(finger, add);
        status.add(stepper_.forces(finger), suffix);
        link_report(finger).each(add);
    }
    status.publish(connection_);
    if (record_ != nullptr) record_->flush();
    longest_us_ = 0.0;
    tell();
}

/// Which of several fingers a line is about.
std::string Session::who(std::size_t finger) const {
    return side_.size() == 1 ? "" : "finger " + std::to_string(finger + 1) + ": ";
}

void Session::tell() {
    const Clock::time_point now = Clock::now();
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        const std::string of = who(finger);
        tell_of_states(side.gate.counters(), now, live_, of);
        live_.look(of + "rejected", side.rejected, now,
                   [&] { return of + why_rejected(*stepper_.scene().model, side.rejected_m); });
    }
}

bool Session::has_states() const {
    return std::any_of(side_.begin(), side_.end(), [](const Side& side) { return side.gate.has_states(); });
}

Clock::time_point Session::last_state() const {
    Clock::time_point last = side_[0].gate.last_state();
    for (const Side& side : side_)
        if (side.gate.has_states()) last = std::max(last, side.gate.last_state());
    return last;
}

LinkReport Session::link_report(std::size_t finger) const {
    LinkReport link = side_[finger].link;
    static_cast<StateCounters&>(link) = side_[finger].gate.counters();
    return link;
}

void add_link_report(const LinkReport& link, const std::string& suffix, SummaryLines& summary) {
    link.each([&](const char* name, std::int64_t value) { summary.add(name + suffix, value); });
    summary.add("latency_mean_us" + suffix, link.latency.mean_us());
    summary.add("latency_p999_us" + suffix, link.latency.quantile_us(0.999));
    summary.add("latency_max_us" + suffix, link.latency.max_us());
}

}  // namespace haptable
