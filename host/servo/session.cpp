// SPDX-License-Identifier: GPL-2.0-or-later
// state -> checked -> step -> force published -> contact published -> counted and recorded
#include "host/servo/session.hpp"

#include <algorithm>

#include "host/session/status.hpp"

namespace haptable {

static_assert(kTick == std::chrono::microseconds(HAPTABLE_TICK_US));

ServoSession::ServoSession(const ServoScene& scene, Connection& connection, ServoRecord* record)
    : scene_(scene), connection_(connection), record_(record), answer_(scene, connection) {
    haptable_init(&servo_);
    connection.subscribe<device_state>(kStateChannel, [this](const device_state& state, std::int64_t received_utime) {
        on_state(state, received_utime);
    });
}

void ServoSession::on_state(const device_state& state, std::int64_t received_utime) {
    if (state.model_hash != 0 && state.model_hash != answer_.model_hash()) {
        ++link_.foreign_states;
        return;
    }
    last_state_ = Clock::now();
    if (is_repeated(state)) {
        // The device did not get our answer: the same again, so that a lost message changes no result.
        ++link_.repeated_states;
        answer_.publish_force(state_, output_);
        return;
    }
    step(state);
    answer_.publish_force(state_, output_);
    const auto latency_us = static_cast<double>(utime_now() - received_utime);
    link_.latency.add(latency_us);
    if (latency_us > static_cast<double>(kTick.count())) ++link_.late_ticks;
    answer_.publish_contact(state_, output_);
    if (record_ != nullptr) record_->add(state.seq, to_finger(state.position_m), output_);
}

bool ServoSession::is_repeated(const device_state& state) const {
    return has_states_ && state.seq == state_.seq && state.utime == state_.utime;
}

void ServoSession::step(const device_state& state) {
    gaps_.note(state.seq);
    has_states_ = true;
    state_ = state;
    const std::array<float, 3> finger_m = to_finger(state.position_m);
    const Clock::time_point begin = Clock::now();
    const std::uint32_t now_us = time_of(state, begin);
    // A gap in time drops the contact whether or not the watchdog was scheduled within it. A device that has begun
    // anew in lockstep counts its time from 0 again: seen on a wrapping clock that is a gap as well.
    if (haptable_watch(&servo_, now_us, &output_) != 0) report_.note(finger_m, output_);
    haptable_step(scene_.model, &servo_, finger_m.data(), now_us, &output_);
    const double step_us = to_us(Clock::now() - begin);
    report_.step.add(step_us);
    longest_step_us_ = std::max(longest_step_us_, step_us);
    report_.note(finger_m, output_);
}

Clock::time_point ServoSession::watch_at() const {
    if (servo_.state == HAPTABLE_SILENT || is_simulated(state_.utime)) return Clock::time_point::max();
    return last_state_ + std::chrono::microseconds(HAPTABLE_SILENCE_US);
}

void ServoSession::watch(Clock::time_point now) {
    if (now < watch_at() || haptable_watch(&servo_, to_firmware_us(now), &output_) == 0) return;
    answer_.publish_force(state_, output_);
    answer_.publish_contact(state_, output_);
}

void ServoSession::publish_status() {
    Status status(answer_.model_hash(), servo_.state, longest_step_us_);
#define HAPTABLE_ADD(name) status(#name, servo_.counters.name);
    HAPTABLE_COUNTERS(HAPTABLE_ADD)
#undef HAPTABLE_ADD
    status.add(report_);
    link_report().each(status);
    status.publish(connection_);
    longest_step_us_ = 0.0;
}

ServoReport ServoSession::report() const {
    ServoReport report = report_;
    report.counters = servo_.counters;
    return report;
}

LinkReport ServoSession::link_report() const {
    LinkReport link = link_;
    link.lost_states = static_cast<std::int64_t>(gaps_.lost());
    return link;
}

}  // namespace haptable
