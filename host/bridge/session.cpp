// SPDX-License-Identifier: GPL-2.0-or-later
// state -> frame -> target -> frame -> checked -> force published -> contact published -> counted and recorded
#include "host/bridge/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/session/status.hpp"

namespace haptable {

namespace {

Clock::duration seconds(double s) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

BridgeSession::BridgeSession(const ServoScene& scene, Connection& connection, SerialTarget& target,
                             const BridgeOptions& options, ServoRecord* record)
    : scene_(scene),
      connection_(connection),
      target_(target),
      options_(options),
      record_(record),
      answer_(scene, connection) {
    connection.subscribe<device_state>(kStateChannel,
                                       [this](const device_state& state, std::int64_t) { on_state(state); });
}

// ---- device -> target ----------------------------------------------------------------------------------------------

void BridgeSession::on_state(const device_state& state) {
    if (state.model_hash != 0 && state.model_hash != answer_.model_hash()) {
        ++report_.foreign_states;
        return;
    }
    last_state_ = Clock::now();
    if (!has_states_ || state.seq != state_.seq || state.utime != state_.utime) return ask(state);
    // The device did not get our answer: the same again, as soon as there is one.
    ++report_.repeated_states;
    if (!waiting_) answer_.publish_force(state_, output_);
}

void BridgeSession::ask(const device_state& state) {
    gaps_.note(state.seq);
    const Clock::time_point now = Clock::now();
    if (waiting_)
        ++report_.lost_answers;
    else
        deaf_since_ = now;
    has_states_ = waiting_ = true;
    state_ = state;
    ++number_;
    const std::array<float, 3> finger_m = to_finger(state.position_m);
    asked_.time_us = time_of(state, now);
    std::copy(finger_m.begin(), finger_m.end(), asked_.position_m);
    first_sent_ = now;
    send();
}

void BridgeSession::send() {
    last_sent_ = Clock::now();
    target_.send(number_, asked_);
}

// ---- target -> device ----------------------------------------------------------------------------------------------

void BridgeSession::take_answers() {
    while (const std::optional<TargetForce> force = target_.take()) take(*force);
}

void BridgeSession::take(const TargetForce& force) {
    if (force.model_hash != scene_.model->hash)
        throw Error(
            fmt::format("{}: the target runs the tables {:016x}, the folder's are {:016x}: build and flash it again",
                        target_.line().name(), force.model_hash, scene_.model->hash));
    if (!waiting_ || force.sequence != number_) {
        ++report_.stale_answers;
        return;
    }
    if (!is_possible(force.output)) {
        ++report_.rejected_forces;
        return;
    }
    waiting_ = false;
    output_ = force.output;
    answer_.publish_force(state_, output_);
    note(output_, Clock::now());
    answer_.publish_contact(state_, output_);
    if (record_ != nullptr) record_->add(state_.seq, to_finger(state_.position_m), output_);
}

/// The second gate: what reaches the device is a number, no more than the device's limit, on nodes that exist.
bool BridgeSession::is_possible(const haptable_output& output) const {
    // Not std::hypot: libstdc++'s, with three arguments, may lose a NaN. Here a NaN fails the comparison.
    double size2 = 0.0;
    for (const float force_n : output.force_n) size2 += double(force_n) * double(force_n);
    const double limit_n = 1.001 * double(scene_.model->max_force_n);
    const bool nodes = output.state != HAPTABLE_CONTACT ||
                       std::all_of(output.vertex, output.vertex + 3,
                                   [this](std::uint16_t vertex) { return vertex < scene_.model->vertex_count; });
    return nodes && size2 <= limit_n * limit_n;
}

void BridgeSession::note(const haptable_output& output, Clock::time_point now) {
    ++report_.ticks;
    if (output.state == HAPTABLE_CONTACT) ++report_.contact_ticks;
    const double us = to_us(now - first_sent_);
    report_.round_trip.add(us);
    longest_us_ = std::max(longest_us_, us);
    report_.note(to_finger(state_.position_m), output);
}

// ---- neither ------------------------------------------------------------------------------------------------------

Clock::time_point BridgeSession::watch_at() const {
    Clock::time_point at = Clock::time_point::max();
    if (waiting_) at = last_sent_ + options_.retry;
    if (has_states_ && !is_simulated(state_.utime) && output_.state != HAPTABLE_SILENT)
        at = std::min(at, last_state_ + std::chrono::microseconds(HAPTABLE_SILENCE_US));
    return at;
}

void BridgeSession::watch(Clock::time_point now) {
    if (now < watch_at()) return;
    if (waiting_ && now - deaf_since_ >= seconds(options_.patience_s))
        throw Error(
            fmt::format("{}: the target has not answered for {} s ({} bytes of garbage came): is it running, "
                        "and is --baud its own?",
                        target_.line().name(), options_.patience_s, target_.skipped_bytes()));
    if (!is_simulated(state_.utime) && now - last_state_ >= std::chrono::microseconds(HAPTABLE_SILENCE_US)) {
        // As the servo itself would: the target sees the gap in time with the next state.
        waiting_ = false;
        output_ = {};
        output_.patch = HAPTABLE_NONE;
        report_.note(to_finger(state_.position_m), output_);
        answer_.publish_force(state_, output_);
        answer_.publish_contact(state_, output_);
        return;
    }
    ++report_.resent_frames;
    send();
}

void BridgeSession::publish_status() {
    Status status(answer_.model_hash(), output_.state, longest_us_);
    report().each(status);
    status.add(report_);
    status.publish(connection_);
    longest_us_ = 0.0;
}

BridgeReport BridgeSession::report() const {
    BridgeReport report = report_;
    report.lost_states = static_cast<std::int64_t>(gaps_.lost());
    report.skipped_bytes = static_cast<std::int64_t>(target_.skipped_bytes());
    report.foreign_frames = static_cast<std::int64_t>(target_.foreign_frames());
    return report;
}

}  // namespace haptable
