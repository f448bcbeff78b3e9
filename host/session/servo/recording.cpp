// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/servo/recording.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <utility>

#include "host/base/error.hpp"
#include "host/link/decode.hpp"
#include "host/link/finger_path.hpp"
#include "host/link/joined.hpp"
#include "host/link/log_reader.hpp"
#include "host/session/scene.hpp"

namespace haptable {

namespace {

bool is_log(const std::filesystem::path& file) {
    constexpr std::array<char, 4> kSync{'\xED', '\xA1', '\xDA', '\x01'};
    std::array<char, 4> begin{};
    return std::ifstream(file, std::ios::binary).read(begin.data(), begin.size()) && begin == kSync;
}

RecordedTick tick_of(const FingerTick& line, std::int64_t number, bool begins) {
    RecordedTick tick{number, static_cast<std::uint32_t>(number) * HAPTABLE_TICK_US};
    for (std::size_t i = 0; i < line.fingers(); ++i) {
        const FingerPlace& at = line.finger(i);
        if (!at.is_away)
            tick.finger[i] = RecordedFinger{.position_m = at.position_m, .buttons = at.buttons, .begins = begins};
    }
    if (line.turn && tick.finger[0]) tick.finger[0]->turn = to_turn(line.turn->data());
    return tick;
}

Recording read_csv(const std::filesystem::path& file) {
    Recording recording;
    for (const FingerTick& line : read_finger_ticks(file, Positions::any)) {
        const bool is_numbered = line.number >= 0;
        const auto number = is_numbered ? line.number : static_cast<std::int64_t>(recording.ticks.size());
        // A servo counts its ticks anew with each device.
        const bool begins = is_numbered && !recording.ticks.empty() && number <= recording.ticks.back().number;
        recording.fingers = std::max(recording.fingers, line.fingers());
        recording.has_tool |= line.turn.has_value();
        recording.ticks.push_back(tick_of(line, number, begins));
    }
    return recording;
}

/// The states of a log wait for their answers; what has its answer is a tick, with what else has one of that time.
class LogRecording {
public:
    LogRecording() { recording_.is_log = true; }

    void take(const LogReader::Event& event) {
        const Heard heard = take_message(
            event.channel, event.data,
            Overloaded{[&](const hand_pose& pose, std::size_t) {
                           poses_.insert_or_assign({pose.session, pose.seq}, pose);
                       },
                       [&](const device_state& state, std::size_t finger) { add(state, event.utime, finger); },
                       [&](const servo_force& force, std::size_t finger) { add(force, finger); }});
        if (heard == Heard::damaged || heard == Heard::other_version) ++recording_.damaged;
    }

    Recording finish() {
        end_tick();
        if (recording_.ticks.empty())
            for (const Asked& one : std::exchange(unanswered_, {})) {
                add_finger(one, one.state.utime, std::nullopt);
                end_tick();
            }
        return std::move(recording_);
    }
    void count_damaged(std::int64_t more) { recording_.damaged += more; }

private:
    struct Asked {
        std::size_t finger = 0;
        device_state state;
        std::int64_t logged_utime = 0;
    };
    /// The finger of a tick, and the tick's number and time where it came first.
    struct Answered {
        RecordedFinger finger;
        std::int64_t number = 0;
        std::uint32_t time_us = 0;
    };
    struct Side {
        OpenStates<Asked> open;
        std::optional<device_state> last;  ///< that was answered
        bool is_there = false;
    };
    void add(const device_state& state, std::int64_t utime, std::size_t finger) {
        Side& side = side_[finger];
        // Asked again, though it has its answer: no tick.
        if (side.last && side.last->session == state.session && side.last->seq == state.seq &&
            side.last->utime == state.utime)
            return;
        if (recording_.ticks.empty() && !joined_.is_open()) keep_unanswered({finger, state, utime});
        side.open.add(state, Asked{finger, state, utime});
    }

    /// Keeps the states of a log in which nobody answers.
    void keep_unanswered(const Asked& asked) {
        const bool again = !unanswered_.empty() && unanswered_.back().finger == asked.finger &&
                           unanswered_.back().state.session == asked.state.session &&
                           unanswered_.back().state.seq == asked.state.seq;
        if (!again) unanswered_.push_back(asked);
    }

    void add(const servo_force& force, std::size_t finger) {
        Side& side = side_[finger];
        if (force.owner != force.session) return;
        if (is_silence(force, side)) return fall_silent(side);
        const std::optional<Asked> asked = side.open.take(force);
        if (!asked) return;
        recording_.tables_hash = static_cast<std::uint64_t>(force.model_hash);
        add_finger(*asked, force.utime,
                   std::array{static_cast<float>(force.force_n[0]), static_cast<float>(force.force_n[1]),
                              static_cast<float>(force.force_n[2])});
    }

    /// The servo's, to a state that it has answered, when no other came.
    static bool is_silence(const servo_force& force, const Side& side) {
        return force.servo_state == servo_force::SILENT && side.last && side.last->session == force.session &&
               side.last->seq == force.seq;
    }
    void fall_silent(Side& side) {
        end_tick();
        side.is_there = false;
    }

    void add_finger(const Asked& asked, std::int64_t utime, std::optional<std::array<float, 3>> force_n) {
        Side& side = side_[asked.finger];
        const bool has_servo_time = is_simulated(asked.state) || recording_.fingers > 1 || asked.finger > 0;
        // One finger has the state's time, which is before the servo's answer; times of two must ascend.
        const std::int64_t at = has_servo_time ? utime : asked.logged_utime;
        Answered answered{{}, asked.state.seq, static_cast<std::uint32_t>(at)};
        std::copy_n(asked.state.position_m, 3, answered.finger.position_m.begin());
        answered.finger.buttons = buttons_of(asked.state);
        take_turn(asked.state, answered.finger);
        answered.finger.begins = begins(side, asked.state);
        answered.finger.force_n = force_n;
        keep(joined_.add(asked.finger, utime, answered));
        recording_.fingers = std::max(recording_.fingers, asked.finger + 1);
        side.last = asked.state;
        side.is_there = true;
        unanswered_.clear();
    }

    /// The hand's, of a tool; poses of states before it belong to none any more.
    void take_turn(const device_state& state, RecordedFinger& finger) {
        const auto pose = poses_.find({state.session, state.seq});
        if (pose == poses_.end()) return;
        finger.turn = to_turn(pose->second.turn);
        recording_.has_tool = true;
        poses_.erase(poses_.begin(), pose);
    }

    /// As the servo's gate judges it.
    static bool begins(const Side& side, const device_state& state) {
        if (!side.last) return false;
        const bool other = side.last->session != state.session;
        const bool begins_again = side.last->servo != 0 && state.servo == 0;
        return other || begins_again || !side.is_there;
    }

    /// Who was not answered stayed where it was.
    void keep(const std::optional<JoinedTick<Answered>::Tick>& joined) {
        if (!joined) return;
        const Answered& first = *joined->part[joined->first];
        RecordedTick tick{first.number, first.time_us};
        for (std::size_t finger = 0; finger < kFingers; ++finger) {
            const Side& side = side_[finger];
            if (joined->part[finger])
                tick.finger[finger] = joined->part[finger]->finger;
            else if (side.is_there)
                tick.finger[finger] = still(*side.last);
        }
        recording_.ticks.push_back(tick);
    }
    void end_tick() { keep(joined_.end()); }

    static RecordedFinger still(const device_state& last) {
        RecordedFinger finger;
        std::copy_n(last.position_m, 3, finger.position_m.begin());
        finger.buttons = buttons_of(last);
        return finger;
    }

    Recording recording_;
    std::array<Side, kFingers> side_;
    JoinedTick<Answered> joined_;
    std::vector<Asked> unanswered_;
    std::map<std::pair<std::int64_t, std::int64_t>, hand_pose> poses_;  ///< of a tool, by session and seq
};

Recording read_log(const std::filesystem::path& file) {
    LogReader events(file);
    LogRecording log;
    while (const auto event = events.next()) log.take(*event);
    log.count_damaged(events.damaged());
    Recording recording = log.finish();
    if (recording.ticks.empty()) throw Error(file.string() + ": has no state of a device: record a session");
    return recording;
}

}  // namespace

Recording read_recording(const std::filesystem::path& file) { return is_log(file) ? read_log(file) : read_csv(file); }

}  // namespace haptable
