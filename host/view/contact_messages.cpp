// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/contact_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/link/connection.hpp"
#include "host/link/joined.hpp"
#include "host/link/log_reader.hpp"
#include "host/link/messages.hpp"

namespace haptable {

namespace {

// A pause of the servo's clock longer than this is cut out of a log: it was stopped, or another session begins.
constexpr std::int64_t kLongestPause_us = 10'000'000;
constexpr std::int64_t kLastUtime = 4'102'444'800'000'000;  // the year 2100
// Another servo is followed when the one that was has been silent for so long.
constexpr std::chrono::seconds kServoGone{1};

Eigen::Vector3d vector(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

/// Where body and tool are and how far the body has swung, as the servo has said last.
class LastMotion {
public:
    void take(const body_modes& message) {
        ringing_ = message.servo;
        swung_ = swung_of(message, static_cast<std::size_t>(std::max(message.count, 0)));
    }
    void take(const body_pose& message) {
        servo_ = message.servo;
        pose_ = pose_of(vector(message.rest_centre_m), vector(message.centre_m),
                        {message.turn[0], message.turn[1], message.turn[2], message.turn[3]});
    }
    void take(const tool_wrench& message) {
        holding_ = message.servo;
        tool_.reset();
        const std::optional<Eigen::Isometry3d> pose =
            pose_of(Eigen::Vector3d::Zero(), vector(message.position_m),
                    {message.turn[0], message.turn[1], message.turn[2], message.turn[3]});
        if (!pose) return;
        tool_.emplace(ContactFrame::Tool{*pose, {}});
        for (std::size_t i = 0; i < static_cast<std::size_t>(message.count); ++i) {
            const Eigen::Vector3d at_m(message.god_object_m[i].data());
            if (message.touches[i] != 0 && at_m.allFinite()) tool_->god_object_m.push_back(at_m);
        }
    }
    std::optional<ContactFrame::Tool> tool(const contact& message) const {
        return message.servo == holding_ ? tool_ : std::nullopt;
    }
    std::optional<Eigen::Isometry3d> of(const contact& message) const {
        return message.servo == servo_ ? pose_ : std::nullopt;
    }
    /// None where that servo has said nothing of it.
    std::vector<float> modes(const contact& message) const {
        return message.servo == ringing_ ? swung_ : std::vector<float>();
    }

private:
    std::int64_t servo_ = 0, ringing_ = 0, holding_ = 0;
    std::optional<Eigen::Isometry3d> pose_;
    std::optional<ContactFrame::Tool> tool_;
    std::vector<float> swung_;
};

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

/// What is left out of a session, and why the first of it was.
class LeftOut {
public:
    void add(const std::string& why) {
        if (count_++ == 0) first_ = why;
    }
    std::int64_t count() const { return count_; }
    const std::string& first() const { return first_; }

private:
    std::int64_t count_ = 0;
    std::string first_;
};

/// Throws Error where the message is of other tables.
void require_tables(const contact& message, const ContactLoads& loads, const std::string& source) {
    if (static_cast<std::uint64_t>(message.model_hash) != loads.tables_hash())
        throw Error(fmt::format(
            "{}: is of the tables {:016x}, but those of {} are {:016x}: give the folder of the servo that "
            "sent it",
            source, static_cast<std::uint64_t>(message.model_hash), loads.tables().name, loads.tables_hash()));
}

/// Why an event is no message of ours.
std::string reason_of(Heard heard, const LogReader::Event& event, const std::string& source) {
    if (heard == Heard::other_version)
        return fmt::format(
            "{}: event {} on {} is of another version of haptable, whose messages have other fields: draw it with that "
            "version",
            source, event.number, event.channel);
    return fmt::format("{}: event {} on {} is no whole message: is the log damaged?", source, event.number,
                       event.channel);
}

/// The newest frames of each finger of one servo, as one.
class AllFingers {
public:
    /// motion: where the body is now, with both.
    void take(std::size_t finger, const contact& message, const ContactFrame& frame, const LastMotion& motion) {
        if (message.servo != servo_) last_ = {};
        servo_ = message.servo;
        last_[finger] = frame;
        for (std::optional<ContactFrame>& one : last_)
            if (one) {
                one->pose = motion.of(message);
                one->modes = motion.modes(message);
                one->tool = motion.tool(message);
            }
        newest_ = finger;
    }
    /// As a servo's CSV has it: the others in the first's frame. Number and time are the newest message's.
    ContactFrame frame() const {
        if (!last_[0]) return *last_[newest_];
        ContactFrame all = *last_[0];
        all.time_s = last_[newest_]->time_s;
        for (std::size_t finger = 1; finger < kFingers; ++finger) {
            const std::optional<ContactFrame>& other = last_[finger];
            if (!other) continue;
            if (other->finger_known)
                all.others.push_back({other->finger_m, other->god_object_m, other->force_n, other->contact});
            all.loads.insert(all.loads.end(), other->loads.begin(), other->loads.end());
        }
        return all;
    }

private:
    std::int64_t servo_ = 0;
    std::size_t newest_ = 0;
    std::array<std::optional<ContactFrame>, kFingers> last_;
};

/// Chooses frames from messages in the order of a log. Those of one time are one tick.
class FrameSelection {
public:
    FrameSelection(const ContactLoads& loads, const FrameChoice& choice, std::string source)
        : loads_(loads),
          choice_(choice),
          source_(std::move(source)),
          wanted_(choice.ticks.begin(), choice.ticks.end()) {}

    /// Throws Error, and takes nothing, where the message is not one that the servo can have sent.
    void take(std::size_t finger, const contact& message) {
        ContactFrame frame = to_frame(message, loads_, 0, source_);
        end_tick(joined_.add(finger, message.utime, message.seq));
        fingers_.take(finger, message, frame, motion);
        ++messages_;
    }

    void finish(const LeftOut& left_out) {
        end_tick(joined_.end());
        if (messages_ == 0 && left_out.count() > 0) throw Error(left_out.first());
        if (messages_ == 0)
            throw Error(fmt::format("{}: holds no message on {}: record it while the servo runs", source_,
                                    channel_of<contact>()));
        if (!wanted_.empty())
            throw Error(fmt::format("{}: has no contact message with seq {}", source_, *wanted_.begin()));
        if (choice_.ticks.empty()) hold_until(last_utime_ - begin_utime_ + 1);
    }

    std::vector<ContactFrame> frames;
    LastMotion motion;

private:
    /// Its number is that of the first of its messages.
    void end_tick(const std::optional<JoinedTick<std::int64_t>::Tick>& tick) {
        if (!tick) return;
        const std::int64_t utime = tick->utime, seq = *tick->part[tick->first];
        ContactFrame frame = fingers_.frame();
        frame.number = seq;
        const bool first = ticks_++ == 0;
        const std::int64_t step = utime - last_utime_;
        if (first || step < 0 || step > kLongestPause_us) {
            // Time goes on from the frame that is there, without the pause.
            begin_utime_ = utime - (first ? 0 : next_us_);
        }
        last_utime_ = utime;
        frame.time_s = static_cast<double>(utime - begin_utime_) * 1e-6;
        if (!choice_.ticks.empty()) {
            if (wanted_.erase(seq) == 1) frames.push_back(std::move(frame));
            return;
        }
        hold_until(utime - begin_utime_);
        held_ = std::move(frame);
    }

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
    JoinedTick<std::int64_t> joined_;  ///< seq
    AllFingers fingers_;
    std::optional<ContactFrame> held_;
    std::int64_t messages_ = 0, ticks_ = 0;
    std::int64_t begin_utime_ = 0;
    std::int64_t last_utime_ = 0;
    std::int64_t next_us_ = 0;
};

}  // namespace

ContactFrame to_frame(const contact& message, const ContactLoads& loads, std::int64_t begin_utime,
                      const std::string& source) {
    const Tables& tables = loads.tables();
    require_tables(message, loads, source);
    if (message.utime < 0 || message.utime > kLastUtime)
        throw Error(
            fmt::format("{}: contact message {} has the time {}: is it damaged?", source, message.seq, message.utime));
    ContactFrame frame;
    frame.number = message.seq;
    frame.time_s = static_cast<double>(message.utime - begin_utime) * 1e-6;
    frame.finger_m = vector(message.finger_m);
    frame.finger_known = frame.finger_m.allFinite();
    frame.contact = message.touches != 0 && message.count > 0 && frame.finger_known;
    if (message.count == 0 || !frame.finger_known) return frame;
    frame.god_object_m = vector(message.god_object_m);
    frame.force_n = vector(message.felt_n);
    if (!frame.god_object_m.allFinite() || !frame.force_n.allFinite())
        throw Error(fmt::format("{}: contact message {} has a god-object or a force that is not finite: is it damaged?",
                                source, message.seq));
    for (std::size_t i = 0; i < static_cast<std::size_t>(message.count); ++i)
        frame.loads.push_back(to_load(message, i, tables, source));
    frame.loads = loads.spread(frame.loads);
    return frame;
}

RecordedContacts read_contact_log(const std::filesystem::path& file, const ContactLoads& loads,
                                  const FrameChoice& choice) {
    LogReader log(file);
    FrameSelection selection(loads, choice, file.string());
    LeftOut left_out;
    while (const std::optional<LogReader::Event> event = log.next()) {
        stop_if_interrupted();
        try {
            const Heard heard = take_message(
                event->channel, event->data,
                Overloaded{[&](const body_pose& pose, std::size_t) { selection.motion.take(pose); },
                           [&](const body_modes& modes, std::size_t) { selection.motion.take(modes); },
                           [&](const tool_wrench& wrench, std::size_t) { selection.motion.take(wrench); },
                           [&](const contact& touched, std::size_t finger) { selection.take(finger, touched); }});
            if (heard == Heard::damaged || heard == Heard::other_version)
                left_out.add(reason_of(heard, *event, file.string()));
        } catch (const Error& error) {
            left_out.add(error.what());
        }
    }
    selection.finish(left_out);
    return {std::move(selection.frames), left_out.count() + log.damaged()};
}

namespace {

/// The newest message of one servo, of those that come.
class LiveFrame {
public:
    LiveFrame(const ContactLoads& loads, std::string source) : loads_(loads), source_(std::move(source)) {}

    void take(std::size_t finger, const contact& message) {
        const Clock::time_point now = Clock::now();
        try {
            require_tables(message, loads_, source_);
            if (begun_ && message.servo != servo_ && now - heard_ < kServoGone)
                return left_out.add(source_ + ": two servos answer there: end one of them");
            if (!begun_) begin_utime_ = message.utime;
            fingers_.take(finger, message, to_frame(message, loads_, begin_utime_, source_), motion);
            frame_ = fingers_.frame();
        } catch (const Error& error) {
            return left_out.add(error.what());
        }
        begun_ = true;
        servo_ = message.servo;
        heard_ = now;
        ++messages;
    }
    /// The frame, once.
    std::optional<ContactFrame> frame() { return std::exchange(frame_, std::nullopt); }

    std::int64_t messages = 0;
    LeftOut left_out;
    LastMotion motion;

private:
    const ContactLoads& loads_;
    std::string source_;
    bool begun_ = false;
    std::int64_t begin_utime_ = 0, servo_ = 0;
    Clock::time_point heard_;
    AllFingers fingers_;
    std::optional<ContactFrame> frame_;
};

}  // namespace

FollowedContacts follow_contacts(const ContactLoads& loads, const LiveLimits& limits,
                                 const std::function<void(const ContactFrame&)>& draw,
                                 const std::function<void(const std::string& url)>& listens) {
    const std::chrono::milliseconds period(limits.every_ms);
    Connection connection;
    LiveFrame newest(loads, connection.url());
    connection.subscribe<body_pose>(channel_of<body_pose>(),
                                    [&](const body_pose& m, std::int64_t) { newest.motion.take(m); });
    connection.subscribe<body_modes>(channel_of<body_modes>(),
                                     [&](const body_modes& m, std::int64_t) { newest.motion.take(m); });
    connection.subscribe<tool_wrench>(channel_of<tool_wrench>(),
                                      [&](const tool_wrench& m, std::int64_t) { newest.motion.take(m); });
    for (std::size_t finger = 0; finger < kFingers; ++finger)
        connection.subscribe<contact>(
            channel_of<contact>(finger),
            [&newest, finger](const contact& message, std::int64_t) { newest.take(finger, message); });
    const Clock::time_point begin = Clock::now();
    const std::chrono::duration<double> length(limits.seconds);
    Clock::time_point next = begin + period;
    if (listens) listens(connection.url());
    std::int64_t frames = 0;
    while (!interrupted() && (limits.frames == 0 || frames < limits.frames) &&
           (limits.seconds <= 0.0 || Clock::now() - begin < length)) {
        // Until the next frame is due, and as long as messages wait: the newest one counts.
        while (!interrupted() && connection.handle_until(next)) {
        }
        if (Clock::now() < next) continue;
        next = std::max(next + period, Clock::now());
        const std::optional<ContactFrame> frame = newest.frame();
        if (!frame) continue;
        draw(*frame);
        ++frames;
    }
    // A session that was over within the first period has a picture too.
    if (frames == 0) {
        while (connection.handle_until(Clock::now())) {
        }
        if (const std::optional<ContactFrame> frame = newest.frame()) draw(*frame), ++frames;
    }
    if (frames == 0 && newest.left_out.count() > 0) throw Error(newest.left_out.first());
    if (frames == 0)
        throw Error(
            fmt::format("{}: no message came on {}: is the servo running with --lcm, and with the same "
                        "LCM_DEFAULT_URL?",
                        connection.url(), channel_of<contact>()));
    return {newest.messages, newest.left_out.count() + static_cast<std::int64_t>(connection.undecodable())};
}

}  // namespace haptable
