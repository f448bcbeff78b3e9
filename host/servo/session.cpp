// SPDX-License-Identifier: GPL-2.0-or-later
// state -> the device's? -> step -> force published -> contact published -> counted and recorded
#include "host/servo/session.hpp"

#include <algorithm>
#include <utility>

#include "host/session/status.hpp"
#include "host/session/tell.hpp"

namespace haptable {

// Of the tables, after each answer: the cube's are gone through in half a second, and a tick is not felt to be longer.
constexpr std::uint32_t kIdleCheck_bytes = HAPTABLE_CHECK_BYTES;

static_assert(kTick == std::chrono::microseconds(HAPTABLE_TICK_US));

ServoSession::ServoSession(const ServoScene& scene, Connection& connection, ServoRecord* record, LiveState::Tell tell,
                           const haptable_body* body)
    : scene_(scene),
      connection_(connection),
      record_(record),
      answer_(scene, connection),
      body_(scene, body),
      gate_(answer_.servo(), answer_.model_hash()),
      live_(std::move(tell)) {
    haptable_init(&servo_);
    require_whole_tables(scene, servo_);
    connection.subscribe<device_state>(kStateChannel, [this](const device_state& state, std::int64_t received_utime) {
        on_state(state, received_utime);
    });
    connection.after_all([this] { answer_newest(); });
}

void ServoSession::on_state(const device_state& state, std::int64_t received_utime) {
    const bool waited = waits_;
    switch (gate_.judge(state, received_utime, Clock::now())) {
        case StateIs::refused:
            return;
        case StateIs::others:
            return answer_.refuse(state, gate_.state().session);
        case StateIs::repeated:
            // The device did not get our answer: the same again, so that a lost message changes no result.
            if (!waits_) answer_.publish_force(gate_.state(), output_);
            return;
        case StateIs::beginning:
            begins_ = true;
            break;
        case StateIs::next:
            break;
    }
    if (waited) gate_.count_skipped();
    waits_ = true;
    received_utime_ = received_utime;
    // Simulated time knows no hurry, and every one of its ticks counts.
    if (is_simulated(state)) answer_newest();
}

void ServoSession::answer_newest() {
    if (!std::exchange(waits_, false)) return;
    if (std::exchange(begins_, false)) end_contact();
    step();
    const device_state& state = gate_.state();
    answer_.publish_force(state, output_);
    const auto latency_us = static_cast<double>(utime_now() - received_utime_);
    link_.latency.add(latency_us);
    if (latency_us > static_cast<double>(kTick.count())) ++link_.late_ticks;
    if (body_.state() != nullptr)
        connection_.publish(kBodyChannel,
                            body_.message(state, is_simulated(state) ? state.utime : utime_now(), answer_.servo()));
    answer_.publish_contact(state, output_);
    haptable_check(scene_.model, &servo_, kIdleCheck_bytes);
    if (record_ != nullptr)
        record_->add(state.seq, to_finger(state.position_m), buttons_of(state), output_, body_.state());
}

/// As after silence: what comes next knows nothing of what was.
void ServoSession::end_contact() { haptable_watch(&servo_, servo_.position_us + HAPTABLE_SILENCE_US, &output_); }

void ServoSession::step() {
    const device_state& state = gate_.state();
    const std::array<float, 3> finger_m = to_finger(state.position_m);
    const Clock::time_point begin = Clock::now();
    const std::uint32_t now_us = time_of(state, begin);
    // A gap in time drops the contact whether or not the watchdog was scheduled within it.
    if (haptable_watch(&servo_, now_us, &output_) != 0) report_.note(finger_m, output_);
    haptable_buttons(&servo_, buttons_of(state));
    body_.step(servo_, finger_m, now_us, output_);
    const double step_us = to_us(Clock::now() - begin);
    report_.step.add(step_us);
    longest_step_us_ = std::max(longest_step_us_, step_us);
    report_.note(finger_m, output_);
    if (output_.state == HAPTABLE_REJECTED) rejected_m_ = finger_m;
}

Clock::time_point ServoSession::watch_at() const {
    if (servo_.state == HAPTABLE_SILENT || is_simulated(gate_.state())) return Clock::time_point::max();
    return gate_.last_state() + std::chrono::microseconds(HAPTABLE_SILENCE_US);
}

void ServoSession::watch(Clock::time_point now) {
    const bool touched = haptable_touches(output_.state) != 0;
    if (now < watch_at() || haptable_watch(&servo_, to_firmware_us(now), &output_) == 0) return;
    if (touched) live_.say(contact_dropped_after(now - gate_.last_state()));
    answer_.publish_force(gate_.state(), output_);
    answer_.publish_contact(gate_.state(), output_);
}

void ServoSession::publish_status() {
    Status status(answer_, gate_.owner(Clock::now()), output_, longest_step_us_);
#define HAPTABLE_ADD(name) status(#name, servo_.counters.name);
    HAPTABLE_COUNTERS(HAPTABLE_ADD)
#undef HAPTABLE_ADD
    status.add(report_);
    link_report().each(status);
    status.publish(connection_);
    if (record_ != nullptr) record_->flush();
    longest_step_us_ = 0.0;
    tell();
}

void ServoSession::tell() {
    const Clock::time_point now = Clock::now();
    tell_of_states(gate_.counters(), now, live_);
    const std::int64_t rejected = std::int64_t{servo_.counters.rejected_positions} + servo_.counters.implausible;
    live_.look("rejected", rejected, now, [this] { return why_rejected(*scene_.model, rejected_m_); });
}

ServoReport ServoSession::report() const {
    ServoReport report = report_;
    report.counters = servo_.counters;
    return report;
}

LinkReport ServoSession::link_report() const {
    LinkReport link = link_;
    static_cast<StateCounters&>(link) = gate_.counters();
    return link;
}

}  // namespace haptable
