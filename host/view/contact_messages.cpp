// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/contact_messages.hpp"

#include <fmt/format.h>

#include <cmath>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <set>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/interrupt.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"

namespace haptable {

namespace {

constexpr std::chrono::microseconds kFramePeriod{33333};
// A pause of the servo's clock longer than this is cut out of a log: it was stopped, or another session begins.
constexpr std::int64_t kLongestPause_us = 10'000'000;

Eigen::Vector3d vector(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

/// Only the limit of the device is known of the force that the user felt: the message has the body's loads.
Eigen::Vector3d felt(const std::vector<NodalForce>& loads, double max_force_n) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // equation 12
    for (const NodalForce& load : loads) sum -= Eigen::Vector3d(load.force_n[0], load.force_n[1], load.force_n[2]);
    const double length = sum.norm();
    return length > max_force_n ? Eigen::Vector3d(sum * (max_force_n / length)) : sum;
}

NodalForce to_load(const contact& message, std::size_t i, const Tables& tables, const std::string& source) {
    const std::int32_t node = message.node[i];
    if (node < 0 || static_cast<std::size_t>(node) >= tables.position.size())
        throw Error(fmt::format("{}: contact message {} loads node {} of a mesh of {}: is it damaged?", source,
                                message.seq, node, tables.position.size()));
    NodalForce load{node, {}};
    for (std::size_t c = 0; c < 3; ++c) {
        if (!std::isfinite(message.force_n[i][c]))
            throw Error(fmt::format("{}: contact message {} has a force that is not finite: is it damaged?", source,
                                    message.seq));
        load.force_n[c] = static_cast<float>(message.force_n[i][c]);
    }
    return load;
}

/// The contact message of an event, or nothing where the event is another one's.
std::optional<contact> decode(const lcm::LogEvent& event, const std::string& source) {
    if (event.channel != kContactChannel) return std::nullopt;
    contact message;
    int used = -1;
    try {
        used = message.decode(event.data, 0, event.datalen);
    } catch (const std::exception&) {  // of a count that no memory can hold
    }
    if (used != event.datalen)
        throw Error(fmt::format("{}: event {} on {} is not a contact message of this version: is the log damaged?",
                                source, event.eventnum, event.channel));
    return message;
}

/// Chooses frames from messages in the order of a log.
class Chooser {
public:
    Chooser(const ContactLoads& loads, const FrameChoice& choice, std::string source)
        : loads_(loads),
          choice_(choice),
          source_(std::move(source)),
          wanted_(choice.ticks.begin(), choice.ticks.end()) {}

    void take(const contact& message) {
        const bool first = messages_++ == 0;
        const std::int64_t step = message.utime - last_utime_;
        if (first || step < 0 || step > kLongestPause_us) {
            // Time goes on from the frame that is there, without the pause.
            begin_utime_ = message.utime - (first ? 0 : next_us_);
        }
        last_utime_ = message.utime;
        ContactFrame frame = to_frame(message, loads_, begin_utime_, source_);
        if (!choice_.ticks.empty()) {
            if (wanted_.erase(message.seq) == 1) frames.push_back(std::move(frame));
            return;
        }
        hold_until(message.utime - begin_utime_);
        held_ = std::move(frame);
    }

    void finish() {
        if (messages_ == 0)
            throw Error(
                fmt::format("{}: holds no message on {}: record it while the servo runs", source_, kContactChannel));
        if (!wanted_.empty())
            throw Error(fmt::format("{}: has no contact message with seq {}", source_, *wanted_.begin()));
        if (choice_.ticks.empty()) hold_until(last_utime_ - begin_utime_ + 1);
    }

    std::vector<ContactFrame> frames;

private:
    /// The newest message so far is what was to be seen at every frame time before `now_us`.
    void hold_until(std::int64_t now_us) {
        for (; held_ && next_us_ < now_us; next_us_ += choice_.every_ms * 1000) {
            frames.push_back(*held_);
            frames.back().time_s = static_cast<double>(next_us_) * 1e-6;
        }
    }

    const ContactLoads& loads_;
    const FrameChoice& choice_;
    std::string source_;
    std::set<std::int64_t> wanted_;
    std::optional<ContactFrame> held_;
    std::int64_t messages_ = 0;
    std::int64_t begin_utime_ = 0;
    std::int64_t last_utime_ = 0;
    std::int64_t next_us_ = 0;
};

}  // namespace

ContactFrame to_frame(const contact& message, const ContactLoads& loads, std::int64_t begin_utime,
                      const std::string& source) {
    const Tables& tables = loads.tables();
    if (static_cast<std::uint64_t>(message.model_hash) != loads.tables_hash())
        throw Error(
            fmt::format("{}: is of the tables {:016x}, but those of {} are {:016x}: give the folder of the servo that "
                        "sent it",
                        source, static_cast<std::uint64_t>(message.model_hash), tables.name, loads.tables_hash()));
    ContactFrame frame;
    frame.number = message.seq;
    frame.time_s = static_cast<double>(message.utime - begin_utime) * 1e-6;
    frame.finger_m = vector(message.finger_m);
    frame.finger_known = frame.finger_m.allFinite();
    frame.contact = message.count > 0 && frame.finger_known;
    if (!frame.contact) return frame;
    frame.god_object_m = vector(message.god_object_m);
    if (!frame.god_object_m.allFinite())
        throw Error(fmt::format("{}: contact message {} has a god-object that is not finite: is it damaged?", source,
                                message.seq));
    for (std::size_t i = 0; i < static_cast<std::size_t>(message.count); ++i)
        frame.loads.push_back(to_load(message, i, tables, source));
    frame.force_n = felt(frame.loads, tables.max_force_n);
    frame.loads = loads.spread(frame.loads);
    return frame;
}

std::vector<ContactFrame> read_contact_log(const std::filesystem::path& file, const ContactLoads& loads,
                                           const FrameChoice& choice) {
    // LCM's reader says nothing about why it cannot open a file: ask for its beginning first.
    constexpr std::string_view kSync("\xED\xA1\xDA\x01", 4);
    std::ifstream in(file, std::ios::binary);
    std::array<char, 4> begin{};
    if (std::filesystem::is_directory(file) || !in) throw Error(file.string() + ": cannot be read: is the path right?");
    if (!in.read(begin.data(), begin.size()) || std::string_view(begin.data(), begin.size()) != kSync)
        throw Error(file.string() + ": is not an LCM log: give a file that lcm-logger wrote");
    lcm::LogFile log(file.string(), "r");
    if (!log.good()) throw Error(file.string() + ": cannot be opened by LCM");
    Chooser chooser(loads, choice, file.string());
    while (const lcm::LogEvent* event = log.readNextEvent()) {
        stop_if_interrupted();
        if (const std::optional<contact> message = decode(*event, file.string())) chooser.take(*message);
    }
    chooser.finish();
    return std::move(chooser.frames);
}

std::int64_t follow_contacts(const ContactLoads& loads, const LiveLimits& limits,
                             const std::function<void(const ContactFrame&)>& draw) {
    Connection connection;
    contact newest;
    bool fresh = false;
    std::int64_t messages = 0, frames = 0, begin_utime = 0;
    connection.subscribe<contact>(kContactChannel, [&](const contact& message, std::int64_t) {
        if (messages++ == 0) begin_utime = message.utime;
        newest = message;
        fresh = true;
    });
    const Clock::time_point begin = Clock::now();
    const auto length = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits.seconds));
    Clock::time_point next = begin + kFramePeriod;
    while (!interrupted() && (limits.frames == 0 || frames < limits.frames) &&
           (limits.seconds <= 0.0 || Clock::now() - begin < length)) {
        // Until the next frame is due, and as long as messages wait: the newest one counts.
        while (!interrupted() && connection.handle_until(next)) {
        }
        if (Clock::now() < next) continue;
        next = std::max(next + kFramePeriod, Clock::now());
        if (!fresh) continue;
        fresh = false;
        draw(to_frame(newest, loads, begin_utime, connection.url()));
        ++frames;
    }
    if (frames == 0)
        throw Error(
            fmt::format("{}: no message came on {}: is the servo running with --lcm, and with the same "
                        "LCM_DEFAULT_URL?",
                        connection.url(), kContactChannel));
    return messages;
}

}  // namespace haptable
