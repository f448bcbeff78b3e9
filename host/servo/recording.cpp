// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/servo/recording.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <utility>

#include "firmware/haptable.h"
#include "host/base/error.hpp"
#include "host/link/channels.hpp"
#include "host/link/decode.hpp"
#include "host/link/finger_path.hpp"
#include "host/link/log_reader.hpp"
#include "host/link/messages.hpp"

namespace haptable {

namespace {

bool is_log(const std::filesystem::path& file) {
    constexpr std::array<char, 4> kSync{'\xED', '\xA1', '\xDA', '\x01'};
    std::array<char, 4> begin{};
    return std::ifstream(file, std::ios::binary).read(begin.data(), begin.size()) && begin == kSync;
}

RecordedTick tick_of(const FingerTick& line, std::int64_t number, bool begins) {
    RecordedTick tick{number, static_cast<std::uint32_t>(number) * HAPTABLE_TICK_US};
    if (!line.is_away) tick.finger[0] = RecordedFinger{line.position_m, line.buttons, begins};
    if (line.second_m && !line.is_second_away)
        tick.finger[1] = RecordedFinger{*line.second_m, line.second_buttons, begins};
    return tick;
}

Recording read_csv(const std::filesystem::path& file) {
    Recording recording;
    for (const FingerTick& line : read_finger_ticks(file, Positions::any)) {
        const bool is_numbered = line.number >= 0;
        const auto number = is_numbered ? line.number : static_cast<std::int64_t>(recording.ticks.size());
        // A servo counts its ticks anew with each device.
        const bool begins = is_numbered && !recording.ticks.empty() && number <= recording.ticks.back().number;
        if (line.second_m) recording.fingers = 2;
        recording.ticks.push_back(tick_of(line, number, begins));
    }
    return recording;
}

/// The states of a log wait for their answers; what has its answer is a tick, with what else has one of that time.
class LogRecording {
public:
    LogRecording() { recording_.is_log = true; }

    void take(const LogReader::Event& event) {
        for (std::size_t finger = 0; finger < kFingers; ++finger) {
            if (event.channel == kStateChannels[finger]) return decode<device_state>(event, finger);
            if (event.channel == kForceChannels[finger]) return decode<servo_force>(event, finger);
        }
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
    using Name = std::pair<std::int64_t, std::int64_t>;  ///< session, seq
    // A state whose answer has not come after so many others has none.
    static constexpr std::size_t kOpen = 4096;

    struct Asked {
        std::size_t finger = 0;
        device_state state;
        std::int64_t logged_utime = 0;
    };
    struct Side {
        std::map<Name, Asked> open;
        std::optional<device_state> last;  ///< that was answered
        bool is_there = false;
    };
    /// A tick that further answers may belong to.
    struct Pending {
        std::int64_t utime = 0;
        RecordedTick tick;
    };

    template <typename Message>
    void decode(const LogReader::Event& event, std::size_t finger) {
        Message message;
        if (decode_whole(event.data, message))
            add(message, event.utime, finger);
        else
            ++recording_.damaged;
    }

    void add(const device_state& state, std::int64_t utime, std::size_t finger) {
        Side& side = side_[finger];
        // Asked again, though it has its answer: no tick.
        if (side.last && side.last->session == state.session && side.last->seq == state.seq &&
            side.last->utime == state.utime)
            return;
        if (recording_.ticks.empty() && !pending_) keep_unanswered({finger, state, utime});
        side.open.try_emplace(Name(state.session, state.seq), Asked{finger, state, utime});
        if (side.open.size() > kOpen) side.open.erase(side.open.begin());
    }

    /// Of a log in which nobody answers.
    void keep_unanswered(const Asked& asked) {
        const bool again = !unanswered_.empty() && unanswered_.back().finger == asked.finger &&
                           unanswered_.back().state.session == asked.state.session &&
                           unanswered_.back().state.seq == asked.state.seq;
        if (!again) unanswered_.push_back(asked);
    }

    void add(const servo_force& force, std::int64_t, std::size_t finger) {
        Side& side = side_[finger];
        if (force.owner != force.session) return;
        if (is_last_word(force, side)) return fall_silent(side);
        const auto found = side.open.find(Name(force.session, force.seq));
        if (found == side.open.end()) return;
        recording_.tables_hash = static_cast<std::uint64_t>(force.model_hash);
        const Asked asked = found->second;
        side.open.erase(found);  // a second answer to it is none
        add_finger(asked, force.utime,
                   std::array{static_cast<float>(force.force_n[0]), static_cast<float>(force.force_n[1]),
                              static_cast<float>(force.force_n[2])});
    }

    /// The servo's, to a state that it has answered, when no other came.
    static bool is_last_word(const servo_force& force, const Side& side) {
        return force.servo_state == servo_force::SILENT && side.last && side.last->session == force.session &&
               side.last->seq == force.seq;
    }
    void fall_silent(Side& side) {
        end_tick();
        side.is_there = false;
    }

    void add_finger(const Asked& asked, std::int64_t utime, std::optional<std::array<float, 3>> force_n) {
        if (pending_ && (pending_->utime != utime || pending_->tick.finger[asked.finger])) end_tick();
        if (!pending_) begin_tick(asked, utime);
        Side& side = side_[asked.finger];
        RecordedFinger finger;
        std::copy_n(asked.state.position_m, 3, finger.position_m.begin());
        finger.buttons = buttons_of(asked.state);
        finger.begins = begins(side, asked.state);
        finger.force_n = force_n;
        pending_->tick.finger[asked.finger] = finger;
        if (asked.finger > 0) recording_.fingers = 2;
        side.last = asked.state;
        side.is_there = true;
        unanswered_.clear();
    }

    void begin_tick(const Asked& asked, std::int64_t utime) {
        const bool has_servo_time = is_simulated(asked.state) || recording_.fingers == 2 || asked.finger > 0;
        // Of one finger the state's, which came before the servo's answer; of two, times must ascend.
        const std::int64_t at = has_servo_time ? utime : asked.logged_utime;
        pending_ = Pending{utime, {asked.state.seq, static_cast<std::uint32_t>(at)}};
    }

    /// As the servo's gate judges it.
    static bool begins(const Side& side, const device_state& state) {
        if (!side.last) return false;
        const bool other = side.last->session != state.session;
        const bool let_go = side.last->servo != 0 && state.servo == 0;
        return other || let_go || !side.is_there;
    }

    /// Who was not answered stayed where it was.
    void end_tick() {
        if (!pending_) return;
        for (std::size_t finger = 0; finger < kFingers; ++finger) {
            const Side& side = side_[finger];
            if (pending_->tick.finger[finger] || !side.is_there) continue;
            RecordedFinger& still = pending_->tick.finger[finger].emplace();
            std::copy_n(side.last->position_m, 3, still.position_m.begin());
            still.buttons = buttons_of(*side.last);
        }
        recording_.ticks.push_back(pending_->tick);
        pending_.reset();
    }

    Recording recording_;
    std::array<Side, kFingers> side_;
    std::optional<Pending> pending_;
    std::vector<Asked> unanswered_;
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
