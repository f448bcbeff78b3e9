// SPDX-License-Identifier: GPL-2.0-or-later
// state -> frame -> target -> frame -> checked -> force published -> contact published -> counted and recorded
#include "host/bridge/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/error.hpp"
#include "host/session/status.hpp"
#include "host/session/tell.hpp"

namespace haptable {

namespace {

Clock::duration seconds(double s) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

BridgeSession::BridgeSession(const ServoScene& scene, Connection& connection, SerialTarget& target,
                             const BridgeOptions& options, ServoRecord* record, LiveState::Tell tell)
    : scene_(scene),
      connection_(connection),
      target_(target),
      options_(options),
      record_(record),
      answer_(scene, connection),
      gate_(answer_.servo(), answer_.model_hash()),
      live_(std::move(tell)) {
    connection.subscribe<device_state>(kStateChannel, [this](const device_state& state, std::int64_t received_utime) {
        on_state(state, received_utime);
    });
    connection.after_all([this] { ask(); });
}

// ---- device -> target ----------------------------------------------------------------------------------------------

void BridgeSession::on_state(const device_state& state, std::int64_t received_utime) {
    const bool overtakes = to_ask_;
    switch (gate_.judge(state, received_utime, Clock::now())) {
        case StateIs::refused:
            return;
        case StateIs::others:
            return answer_.refuse(state, gate_.state().session);
        case StateIs::repeated:
            // The device did not get our answer: the same again, as soon as there is one.
            if (!waiting_ && !to_ask_) answer_.publish_force(state_, output_, utime_of(state_));
            return;
        case StateIs::beginning:
            begins_ = true;
            break;
        case StateIs::next:
            break;
    }
    if (overtakes) gate_.count_skipped();
    to_ask_ = true;
    if (is_simulated(state)) ask();
}

void BridgeSession::ask() {
    if (!std::exchange(to_ask_, false)) return;
    const Clock::time_point now = Clock::now();
    if (waiting_)
        ++report_.lost_answers;
    else
        deaf_since_ = now;
    state_ = gate_.state();
    const std::uint32_t time_us = time_of(state_, now);
    // The target knows no sessions: a gap in its time tells it that what was before is over.
    if (std::exchange(begins_, false) && number_ > 0) clock_us_ = asked_.time_us + HAPTABLE_SILENCE_US - time_us;
    asked_.time_us = time_us + clock_us_;
    waiting_ = true;
    ++number_;
    const std::array<float, 3> finger_m = to_finger(state_.position_m);
    std::copy(finger_m.begin(), finger_m.end(), asked_.position_m);
    asked_.buttons = buttons_of(state_);
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
    answer_.publish_force(state_, output_, utime_of(state_));
    note(output_, Clock::now());
    answer_.publish_contact(state_, output_);
    if (record_ != nullptr) record_->add(state_.seq, to_finger(state_.position_m), buttons_of(state_), output_);
}

/// What reaches the device is what a servo of these tables can have said, whatever the frame's CRC: a state that there
/// is, numbers, no more than the device's limit, none without contact (but what a release lets fade), nodes that exist.
bool BridgeSession::is_possible(const haptable_output& output) const {
    const haptable_model& model = *scene_.model;
    const auto finite = [](const float v[3]) {
        return std::all_of(v, v + 3, [](float x) { return std::isfinite(x); });
    };
    if (output.state > HAPTABLE_FAULTED || !finite(output.force_n) || !finite(output.god_object_m)) return false;
    if (!std::all_of(output.nodal_force_n, output.nodal_force_n + 3, finite)) return false;
    const double size_n = std::hypot(output.force_n[0], output.force_n[1], output.force_n[2]);
    if (size_n > 1.001 * double(model.max_force_n)) return false;
    if (haptable_touches(output.state) != 0) return is_on_a_patch(output);
    if (output.state == HAPTABLE_FREE && output.vertex[0] != HAPTABLE_NONE && !is_on_a_patch(output)) return false;
    const bool fades = output.state == HAPTABLE_FREE && (model.release != nullptr || model.passivity != nullptr);
    return fades || size_n <= 0.0;
}

/// Its corners are vertices, and the god-object lies between them.
bool BridgeSession::is_on_a_patch(const haptable_output& output) const {
    constexpr float kRounding = 1e-4F;  // of area coordinates, which sum to 1
    float sum = 0.0F;
    for (std::size_t c = 0; c < 3; ++c) {
        if (output.vertex[c] >= scene_.model->vertex_count) return false;
        if (!(output.alpha[c] >= -kRounding && output.alpha[c] <= 1.0F + kRounding)) return false;
        sum += output.alpha[c];
    }
    return std::abs(sum - 1.0F) <= kRounding;
}

void BridgeSession::note(const haptable_output& output, Clock::time_point now) {
    ++report_.ticks;
    if (haptable_touches(output.state) != 0) ++report_.contact_ticks;
    const double us = to_us(now - first_sent_);
    report_.round_trip.add(us);
    longest_us_ = std::max(longest_us_, us);
    report_.note(to_finger(state_.position_m), output);
    if (output.state != HAPTABLE_REJECTED) return;
    ++rejected_;
    rejected_m_ = to_finger(state_.position_m);
}

// ---- neither ------------------------------------------------------------------------------------------------------

Clock::time_point BridgeSession::watch_at() const {
    Clock::time_point at = Clock::time_point::max();
    if (waiting_) at = last_sent_ + options_.retry;
    if (has_states() && !is_simulated(gate_.state()) && output_.state != HAPTABLE_SILENT)
        at = std::min(at, last_state() + std::chrono::microseconds(HAPTABLE_SILENCE_US));
    return at;
}

void BridgeSession::watch(Clock::time_point now) {
    if (now < watch_at()) return;
    if (waiting_ && now - deaf_since_ >= seconds(options_.patience_s))
        throw Error(
            fmt::format("{}: the target has not answered for {} s ({} bytes of garbage came): is it running, "
                        "and is --baud its own?",
                        target_.line().name(), options_.patience_s, target_.skipped_bytes()));
    if (!is_simulated(gate_.state()) && now - last_state() >= std::chrono::microseconds(HAPTABLE_SILENCE_US)) {
        // As the servo itself would: the target sees the gap in time with the next state.
        if (haptable_touches(output_.state) != 0) live_.say(contact_dropped_after(now - last_state()));
        waiting_ = false;
        output_ = {};
        output_.patch = HAPTABLE_NONE;
        report_.note(to_finger(state_.position_m), output_);
        answer_.publish_force(state_, output_, utime_of(state_));
        answer_.publish_contact(state_, output_);
        return;
    }
    ++report_.resent_frames;
    send();
}

void BridgeSession::publish_status() {
    Status status(answer_, gate_.owner(Clock::now()), output_, longest_us_);
    report().each(status);
    status.add(report_);
    status.publish(connection_);
    if (record_ != nullptr) record_->flush();
    longest_us_ = 0.0;
    tell();
}

void BridgeSession::tell() {
    const Clock::time_point now = Clock::now();
    tell_of_states(gate_.counters(), now, live_);
    live_.look("rejected", rejected_, now, [this] { return why_rejected(*scene_.model, rejected_m_); });
}

BridgeReport BridgeSession::report() const {
    BridgeReport report = report_;
    static_cast<StateCounters&>(report) = gate_.counters();
    report.skipped_bytes = static_cast<std::int64_t>(target_.skipped_bytes());
    report.foreign_frames = static_cast<std::int64_t>(target_.foreign_frames());
    return report;
}

}  // namespace haptable
