// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/run/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace haptable {

namespace {

const char* word_of(int servo_state) {
    constexpr std::array kWords{"silent", "free", "contact", "rejected", "limited", "faulted"};
    if (servo_state < 0) return "no servo";
    return servo_state < static_cast<int>(kWords.size()) ? kWords[static_cast<std::size_t>(servo_state)] : "other";
}

/// Every message that is whole, and nothing that is not.
template <typename Message, typename Take>
void decode_to(std::span<const std::uint8_t> bytes, Take&& take) {
    Message message;
    if (decode_whole(bytes, message)) take(message);
}

}  // namespace

bool is_fault(const std::string& counter) {
    const bool is_work = counter == "ticks" || counter == "contacts" || counter == "contact_ticks" ||
                         counter.starts_with("most_") || counter.starts_with("energy_");
    return !is_work;
}

Recorder::Recorder(Connection& connection, LogWriter& log) : log_(log) {
    using Bytes = std::span<const std::uint8_t>;
    connection.listen(kStateChannel, [this](Bytes bytes, std::int64_t utime) {
        keep(kStateChannel, bytes, utime);
        decode_to<device_state>(bytes, [&](const device_state& state) { take(state, utime); });
    });
    connection.listen(kForceChannel, [this](Bytes bytes, std::int64_t utime) {
        keep(kForceChannel, bytes, utime);
        decode_to<servo_force>(bytes, [&](const servo_force& force) { take(force, utime); });
    });
    connection.listen(kContactChannel, [this](Bytes bytes, std::int64_t utime) {
        keep(kContactChannel, bytes, utime);
        decode_to<contact>(bytes, [&](const contact& touched) { take(touched); });
    });
    connection.listen(kStatusChannel, [this](Bytes bytes, std::int64_t utime) {
        keep(kStatusChannel, bytes, utime);
        decode_to<servo_status>(bytes, [&](const servo_status& status) { take(status); });
    });
}

void Recorder::keep(const char* channel, std::span<const std::uint8_t> bytes, std::int64_t utime) {
    log_.add(channel, bytes, utime);
}

void Recorder::take(const device_state& state, std::int64_t utime) {
    ++states_;
    simulated_ = is_simulated(state);
    sent_[static_cast<std::size_t>(static_cast<std::uint64_t>(state.seq) % kWaiting)] = {state.seq, utime};
}

void Recorder::take(const servo_force& force, std::int64_t utime) {
    if (force.owner != force.session) return;
    servo_state_ = force.servo_state;
    force_n_ = std::hypot(force.force_n[0], force.force_n[1], force.force_n[2]);
    auto& [seq, sent_utime] = sent_[static_cast<std::size_t>(static_cast<std::uint64_t>(force.seq) % kWaiting)];
    if (seq != force.seq || sent_utime == 0) return;
    ++answers_;
    latency_.add(static_cast<double>(utime - std::exchange(sent_utime, 0)));
}

void Recorder::take(const contact& touched) {
    double square_m2 = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        square_m2 += (touched.finger_m[axis] - touched.god_object_m[axis]) *
                     (touched.finger_m[axis] - touched.god_object_m[axis]);
    depth_m_ = touched.touches != 0 ? std::sqrt(square_m2) : 0.0;
}

void Recorder::take(const servo_status& status) {
    for (std::size_t i = 0; i < status.name.size(); ++i)
        if (is_fault(status.name[i])) faults_[status.name[i]] = status.value[i];
}

std::string Recorder::grown_faults() {
    std::string grown;
    for (const auto& [name, count] : faults_)
        if (const std::int64_t more = count - std::exchange(told_faults_[name], count); more != 0)
            grown += fmt::format("  {} {:+}", name, more);
    return grown;
}

std::string Recorder::line() {
    const std::int64_t ticks = states_ - std::exchange(told_states_, states_);
    const std::int64_t answered = std::exchange(answers_, 0);
    std::string line = fmt::format("{:8}  {:6.3f} N  {:5.2f} mm  {} ticks, {} unanswered", word_of(servo_state_),
                                   force_n_, 1e3 * depth_m_, ticks, std::max<std::int64_t>(ticks - answered, 0));
    if (!simulated_ && latency_.count() > 0)
        line += fmt::format("  latency {:.0f} us, 99.9 % {:.0f} us", latency_.mean_us(), latency_.quantile_us(0.999));
    latency_ = {};
    return line + grown_faults();
}

}  // namespace haptable
