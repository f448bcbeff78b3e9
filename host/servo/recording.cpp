// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/servo/recording.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <utility>

#include "firmware/haptable.h"
#include "host/base/error.hpp"
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

Recording read_csv(const std::filesystem::path& file) {
    Recording recording;
    for (const FingerTick& tick : read_finger_ticks(file, Positions::any)) {
        const bool is_numbered = tick.number >= 0;
        const auto number = is_numbered ? tick.number : static_cast<std::int64_t>(recording.ticks.size());
        // A servo counts its ticks anew with each device.
        const bool begins = is_numbered && !recording.ticks.empty() && number <= recording.ticks.back().number;
        recording.ticks.push_back({number, static_cast<std::uint32_t>(number) * HAPTABLE_TICK_US, tick.position_m,
                                   tick.buttons, begins, std::nullopt, tick.second_m, tick.second_buttons});
    }
    return recording;
}

/// The states of a log wait for their answers; what has its answer is a tick.
class LogRecording {
public:
    void take(const LogReader::Event& event) {
        if (event.channel == kStateChannel) return decode<device_state>(event);
        if (event.channel == kForceChannel) decode<servo_force>(event);
    }

    Recording finish() {
        if (recording_.ticks.empty())
            for (const auto& [state, utime] : std::exchange(unanswered_, {})) add_tick(state, utime, std::nullopt);
        return std::move(recording_);
    }
    void count_damaged(std::int64_t more) { recording_.damaged += more; }

private:
    using Name = std::pair<std::int64_t, std::int64_t>;  ///< session, seq
    // A state whose answer has not come after so many others has none.
    static constexpr std::size_t kOpen = 4096;

    template <typename Message>
    void decode(const LogReader::Event& event) {
        Message message;
        if (decode_whole(event.data, message))
            add(message, event.utime);
        else
            ++recording_.damaged;
    }

    void add(const device_state& state, std::int64_t utime) {
        // Asked again, though it has its answer: no tick.
        if (last_ && last_->session == state.session && last_->seq == state.seq && last_->utime == state.utime) return;
        if (recording_.ticks.empty()) keep_unanswered(state, utime);
        open_.try_emplace(Name(state.session, state.seq), state, utime);
        if (open_.size() > kOpen) open_.erase(open_.begin());
    }

    /// Of a log in which nobody answers.
    void keep_unanswered(const device_state& state, std::int64_t utime) {
        const bool again = !unanswered_.empty() && unanswered_.back().first.session == state.session &&
                           unanswered_.back().first.seq == state.seq;
        if (!again) unanswered_.emplace_back(state, utime);
    }

    void add(const servo_force& force, std::int64_t) {
        const auto found = open_.find(Name(force.session, force.seq));
        if (found == open_.end() || force.owner != force.session) return;
        recording_.tables_hash = static_cast<std::uint64_t>(force.model_hash);
        const auto [state, utime] = found->second;
        open_.erase(found);  // a second answer to it is none
        add_tick(state, utime,
                 std::array{static_cast<float>(force.force_n[0]), static_cast<float>(force.force_n[1]),
                            static_cast<float>(force.force_n[2])});
    }

    void add_tick(const device_state& state, std::int64_t utime, std::optional<std::array<float, 3>> force_n) {
        RecordedTick tick;
        tick.number = state.seq;
        tick.time_us = static_cast<std::uint32_t>(is_simulated(state) ? state.utime : utime);
        std::copy_n(state.position_m, 3, tick.position_m.begin());
        tick.buttons = buttons_of(state);
        // As the servo's gate judges it.
        const bool other = last_ && last_->session != state.session;
        const bool let_go = last_ && last_->servo != 0 && state.servo == 0;
        tick.begins = other || let_go;
        tick.force_n = force_n;
        recording_.ticks.push_back(tick);
        last_ = state;
        unanswered_.clear();
    }

    Recording recording_;
    std::map<Name, std::pair<device_state, std::int64_t>> open_;
    std::vector<std::pair<device_state, std::int64_t>> unanswered_;
    std::optional<device_state> last_;
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
