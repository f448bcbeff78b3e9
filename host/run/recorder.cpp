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

}  // namespace

bool is_fault(const std::string& counter) {
    const std::string suffix = kFingerSuffix[1];
    const std::string name = counter.ends_with(suffix) ? counter.substr(0, counter.size() - suffix.size()) : counter;
    const bool is_work = name == "ticks" || name == "contacts" || name == "contact_ticks" || name == "session" ||
                         name == "servo_state" || name.starts_with("most_") || name.starts_with("energy_");
    return !is_work;
}

Recorder::Recorder(Connection& connection, LogWriter& log) : log_(log) {
    each_channel([this, &connection]<typename Message>(const char* channel, std::size_t finger) {
        connection.listen(channel, [this, channel, finger](std::span<const std::uint8_t> bytes, std::int64_t utime) {
            log_.add(channel, bytes, utime);
            Message message{};
            if (decode_whole(bytes, message)) take(message, utime, side_[finger]);
        });
    });
}

void Recorder::take(const device_state& state, std::int64_t utime, Side& side) {
    simulated_ = is_simulated(state);
    ++side.states;
    side.sent.add(state, utime);
}

void Recorder::take(const servo_force& force, std::int64_t utime, Side& side) {
    if (force.owner != force.session) return;
    side.servo_state = force.servo_state;
    side.force_n = std::hypot(force.force_n[0], force.force_n[1], force.force_n[2]);
    const std::optional<std::int64_t> sent_utime = side.sent.take(force);
    if (!sent_utime) return;
    ++side.answers;
    side.latency.add(static_cast<double>(utime - *sent_utime));
}

void Recorder::take(const body_pose& pose, std::int64_t, Side&) { body_.take(pose); }

void Recorder::take(const tool_wrench& wrench, std::int64_t, Side&) { body_.take(wrench); }

void Recorder::take(const contact& touched, std::int64_t, Side& side) const {
    side.depth_m = body_.dent_of(touched).depth_m;
}

void Recorder::take(const servo_status& status, std::int64_t, Side&) {
    for (std::size_t i = 0; i < status.name.size(); ++i)
        if (is_fault(status.name[i]) && (faults_.size() < kMostFaults || faults_.contains(status.name[i])))
            faults_[status.name[i]] = status.value[i];
}

std::string Recorder::grown_faults() {
    std::string grown;
    for (const auto& [name, count] : faults_)
        if (const std::int64_t more = count - std::exchange(told_faults_[name], count); more != 0)
            grown += fmt::format("  {} {:+}", name, more);
    return grown;
}

std::string Recorder::line(Side& side) const {
    const std::int64_t ticks = side.states - std::exchange(side.told_states, side.states);
    const std::int64_t answered = std::exchange(side.answers, 0);
    std::string line =
        fmt::format("{:8}  {:6.3f} N  {:5.2f} mm  {} ticks, {} unanswered", word_of(side.servo_state), side.force_n,
                    1e3 * side.depth_m, ticks, std::max<std::int64_t>(ticks - answered, 0));
    if (!simulated_ && side.latency.count() > 0)
        line += fmt::format("  latency {:.0f} us, 99.9 % {:.0f} us", side.latency.mean_us(),
                            side.latency.quantile_us(0.999));
    side.latency = {};
    return line;
}

std::string Recorder::line() {
    std::string both = line(side_[0]);
    for (std::size_t finger = 1; finger < kFingers; ++finger)
        if (side_[finger].states > 0) both += "  |  " + line(side_[finger]);
    return both + grown_faults();
}

}  // namespace haptable
