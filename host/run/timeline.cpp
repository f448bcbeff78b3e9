// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/run/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "host/base/file.hpp"
#include "host/link/decode.hpp"
#include "host/link/log_reader.hpp"
#include "host/link/messages.hpp"

namespace haptable {

namespace {

// States whose answer may still come.
constexpr std::size_t kOpen = 4096;

class Reader {
public:
    void take(const LogReader::Event& event) {
        if (event.channel == kStateChannel) return decode<device_state>(event);
        if (event.channel == kForceChannel) return decode<servo_force>(event);
        if (event.channel == kContactChannel) return decode<contact>(event);
        if (event.channel == kStatusChannel) decode<servo_status>(event);
    }

    Timeline timeline;

private:
    struct Open {
        std::int64_t session = 0, seq = -1, utime = 0;
        std::size_t tick = 0;
    };

    template <typename Message>
    void decode(const LogReader::Event& event) {
        Message message;
        if (decode_whole(event.data, message))
            add(message, event.utime);
        else
            ++timeline.damaged;
    }

    Open& open(std::int64_t seq) { return open_[static_cast<std::size_t>(static_cast<std::uint64_t>(seq) % kOpen)]; }

    Tick* asked(std::int64_t session, std::int64_t seq) {
        const Open& found = open(seq);
        return found.session == session && found.seq == seq ? &timeline.ticks[found.tick] : nullptr;
    }

    void add(const device_state& state, std::int64_t utime) {
        if (asked(state.session, state.seq) != nullptr) return;  // once more: no tick
        timeline.simulated = is_simulated(state);
        const std::int64_t at = timeline.simulated ? state.utime : utime;
        if (timeline.ticks.empty()) begin_ = at;
        open(state.seq) = {state.session, state.seq, utime, timeline.ticks.size()};
        Tick tick;
        tick.time_s = 1e-6 * static_cast<double>(at - begin_);
        tick.seq = state.seq;
        std::copy_n(state.position_m, 3, tick.finger_m.begin());
        timeline.ticks.push_back(tick);
    }

    void add(const servo_force& force, std::int64_t utime) {
        Tick* tick = asked(force.session, force.seq);
        if (tick == nullptr || force.owner != force.session || tick->answered) return;
        timeline.tables_hash = static_cast<std::uint64_t>(force.model_hash);
        tick->answered = true;
        tick->servo_state = force.servo_state;
        std::copy_n(force.force_n, 3, tick->force_n.begin());
        if (!timeline.simulated) tick->latency_us = static_cast<double>(utime - open(force.seq).utime);
        account(*tick, open(force.seq).tick);
    }

    /// The force before this one was held until now (Hannaford and Ryu 2002).
    void account(Tick& tick, std::size_t index) {
        for (std::size_t axis = 0; held_ && axis < 3; ++axis)
            given_j_ +=
                timeline.ticks[*held_].force_n[axis] * (tick.finger_m[axis] - timeline.ticks[*held_].finger_m[axis]);
        tick.given_j = given_j_;
        const bool acts = tick.servo_state == servo_force::CONTACT || tick.servo_state == servo_force::LIMITED ||
                          tick.servo_state == servo_force::FREE;
        held_ = acts ? std::optional(index) : std::nullopt;
    }

    void add(const contact& touched, std::int64_t) {
        Tick* tick = asked(touched.session, touched.seq);
        if (tick == nullptr) return;
        std::copy_n(touched.god_object_m, 3, tick->god_object_m.begin());
        tick->depth_m = tick->stored_j = 0.0;
        for (std::size_t axis = 0; touched.touches != 0 && axis < 3; ++axis) {
            const double u_m = touched.finger_m[axis] - touched.god_object_m[axis];
            tick->depth_m = std::hypot(tick->depth_m, u_m);
            for (const auto& load_n : touched.force_n) tick->stored_j += 0.5 * load_n[axis] * u_m;
        }
    }

    void add(const servo_status& status, std::int64_t) {
        StatusPoint point;
        point.time_s = timeline.ticks.empty() ? 0.0 : timeline.ticks.back().time_s;
        for (std::size_t i = 0; i < status.name.size(); ++i) point.counters[status.name[i]] = status.value[i];
        timeline.statuses.push_back(std::move(point));
    }

    std::vector<Open> open_ = std::vector<Open>(kOpen);
    std::int64_t begin_ = 0;
    std::optional<std::size_t> held_;  ///< the tick whose force acts
    double given_j_ = 0.0;
};

void append(double value, std::string& line) {
    line += ',';
    if (!std::isnan(value)) fmt::format_to(std::back_inserter(line), "{:.9g}", value);
}

}  // namespace

double Tick::force_size_n() const { return std::hypot(force_n[0], force_n[1], force_n[2]); }

Timeline read_timeline(const std::filesystem::path& log) {
    LogReader events(log);
    Reader reader;
    while (const auto event = events.next()) reader.take(*event);
    reader.timeline.damaged += events.damaged();
    return std::move(reader.timeline);
}

void write_csv(const Timeline& timeline, const std::filesystem::path& file) {
    std::string text =
        "time_s,seq,x,y,z,servo_state,god_x,god_y,god_z,force_x,force_y,force_z,depth_m,latency_us,"
        "energy_stored_j,energy_given_j\n";
    for (const Tick& tick : timeline.ticks) {
        fmt::format_to(std::back_inserter(text), "{:.6f},{}", tick.time_s, tick.seq);
        for (const double x_m : tick.finger_m) fmt::format_to(std::back_inserter(text), ",{:.9g}", x_m);
        text += ',';
        if (tick.answered) text += std::to_string(tick.servo_state);
        for (const double x_m : tick.god_object_m) append(x_m, text);
        for (const double x_n : tick.force_n) append(x_n, text);
        for (const double value : {tick.depth_m, tick.latency_us, tick.stored_j, tick.given_j}) append(value, text);
        text += '\n';
    }
    write_file(file, text);
}

}  // namespace haptable
