// SPDX-License-Identifier: GPL-2.0-or-later
// state -> checked -> step -> force published -> contact published -> counted and recorded
#include "host/servo/session.hpp"

#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

/// The firmware's wrapping clock.
std::uint32_t to_firmware_us(Clock::time_point now) {
    return static_cast<std::uint32_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count());
}

/// Simulated time is the message's, real time is this machine's: the device's clock may be another one.
std::uint32_t time_of(const device_state& state, Clock::time_point now) {
    return is_simulated(state.utime) ? static_cast<std::uint32_t>(state.utime) : to_firmware_us(now);
}

}  // namespace

ServoSession::ServoSession(const ServoScene& scene, Connection& connection, ServoRecord* record)
    : scene_(scene), connection_(connection), record_(record) {
    haptable_init(&servo_);
    force_.model_hash = contact_.model_hash = static_cast<std::int64_t>(scene.model->hash);
    contact_.node.reserve(3);
    contact_.force_n.resize(3);
    for (auto& force_n : contact_.force_n) force_n.reserve(3);
    connection.subscribe<device_state>(kStateChannel, [this](const device_state& state, std::int64_t received_utime) {
        on_state(state, received_utime);
    });
}

void ServoSession::on_state(const device_state& state, std::int64_t received_utime) {
    if (state.model_hash != 0 && state.model_hash != force_.model_hash) {
        ++link_.foreign_states;
        return;
    }
    last_state_ = Clock::now();
    if (is_repeated(state)) {
        // The device did not get our answer: the same again, so that a lost message changes no result.
        ++link_.repeated_states;
        answer();
        return;
    }
    step(state);
    answer();
    const auto latency_us = static_cast<double>(utime_now() - received_utime);
    link_.latency.add(latency_us);
    if (latency_us > static_cast<double>(kTick.count())) ++link_.late_ticks;
    publish_contact();
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
    haptable_watch(&servo_, now_us, &output_);
    haptable_step(scene_.model, &servo_, finger_m.data(), now_us, &output_);
    note_output(to_us(Clock::now() - begin));
}

void ServoSession::note_output(double step_us) {
    report_.step.add(step_us);
    longest_step_us_ = std::max(longest_step_us_, step_us);
    const float* force_n = output_.force_n;
    report_.largest_force_n = std::max(report_.largest_force_n, std::hypot<double>(force_n[0], force_n[1], force_n[2]));
}

void ServoSession::answer() {
    force_.utime = is_simulated(state_.utime) ? state_.utime : utime_now();
    force_.seq = state_.seq;
    std::copy_n(output_.force_n, 3, force_.force_n);
    force_.servo_state = static_cast<std::int8_t>(output_.state);
    connection_.publish(kForceChannel, force_);
}

void ServoSession::publish_contact() {
    contact_.utime = force_.utime;
    contact_.seq = state_.seq;
    std::copy_n(state_.position_m, 3, contact_.finger_m);
    std::copy_n(output_.god_object_m, 3, contact_.god_object_m);
    contact_.node.clear();
    for (std::size_t corner = 0; corner < 3 && output_.state == HAPTABLE_CONTACT; ++corner) {
        contact_.node.push_back(mesh_node(scene_, output_, corner));
        contact_.force_n[corner].assign(output_.nodal_force_n[corner], output_.nodal_force_n[corner] + 3);
    }
    contact_.count = static_cast<std::int32_t>(contact_.node.size());
    connection_.publish(kContactChannel, contact_);
}

Clock::time_point ServoSession::watch_at() const {
    if (servo_.state == HAPTABLE_SILENT || is_simulated(state_.utime)) return Clock::time_point::max();
    return last_state_ + std::chrono::microseconds(HAPTABLE_SILENCE_US);
}

void ServoSession::watch(Clock::time_point now) {
    if (now < watch_at() || haptable_watch(&servo_, to_firmware_us(now), &output_) == 0) return;
    answer();
    publish_contact();
}

void ServoSession::publish_status() {
    servo_status status{};
    status.utime = utime_now();
    status.model_hash = force_.model_hash;
    status.servo_state = static_cast<std::int8_t>(servo_.state);
    status.longest_step_us = longest_step_us_;
    const auto add = [&status](const char* name, std::uint64_t value) {
        status.name.emplace_back(name);
        status.value.push_back(static_cast<std::int64_t>(value));
    };
#define HAPTABLE_ADD(name) add(#name, servo_.counters.name);
    HAPTABLE_COUNTERS(HAPTABLE_ADD)
#undef HAPTABLE_ADD
    add("lost_states", gaps_.lost());
    add("late_ticks", link_.late_ticks);
    add("repeated_states", link_.repeated_states);
    add("foreign_states", link_.foreign_states);
    add("undecodable_messages", connection_.undecodable());
    status.count = static_cast<std::int32_t>(status.name.size());
    connection_.publish(kStatusChannel, status);
    longest_step_us_ = 0.0;
}

ServoReport ServoSession::report() const {
    ServoReport report = report_;
    report.counters = servo_.counters;
    return report;
}

LinkReport ServoSession::link_report() const {
    LinkReport link = link_;
    link.lost_states = gaps_.lost();
    return link;
}

}  // namespace haptable
