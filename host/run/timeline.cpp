// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/run/timeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "host/base/file.hpp"
#include "host/link/decode.hpp"
#include "host/link/joined.hpp"
#include "host/link/log_reader.hpp"
#include "host/link/messages.hpp"
#include "host/run/body_frame.hpp"

namespace haptable {

namespace {

class Reader {
public:
    void take(const LogReader::Event& event) {
        const Heard heard = take_message(
            event.channel, event.data,
            Overloaded{[&](const device_state& state, std::size_t finger) { add(state, event.utime, side_[finger]); },
                       [&](const servo_force& force, std::size_t finger) { add(force, event.utime, side_[finger]); },
                       [&](const body_pose& pose, std::size_t) { body_.take(pose); },
                       [&](const tool_wrench& wrench, std::size_t) { body_.take(wrench); },
                       [&](const contact& touched, std::size_t finger) { add(touched, side_[finger]); },
                       [&](const servo_status& status, std::size_t) { add(status, side_[0]); }});
        if (heard == Heard::damaged || heard == Heard::other_version) ++timeline_.damaged;
    }

    Timeline finish(std::int64_t damaged) {
        timeline_.damaged += damaged;
        timeline_.ticks = std::move(side_[0].ticks);
        for (std::size_t finger = 1; finger < kFingers; ++finger)
            timeline_.others.push_back(std::move(side_[finger].ticks));
        while (!timeline_.others.empty() && timeline_.others.back().empty()) timeline_.others.pop_back();
        return std::move(timeline_);
    }

private:
    struct Open {
        std::int64_t utime = 0;
        std::size_t tick = 0;
    };

    /// A finger and its device.
    struct Side {
        std::vector<Tick> ticks;
        OpenStates<Open> open;
        std::optional<std::size_t> held;  ///< the tick whose force acts
        double given_j = 0.0;
    };

    double since_begin_s(std::int64_t utime) {
        if (!begin_) begin_ = utime;
        return 1e-6 * static_cast<double>(utime - *begin_);
    }

    void add(const device_state& state, std::int64_t utime, Side& side) {
        if (!side.open.add(state, {utime, side.ticks.size()})) return;  // once more: no tick
        timeline_.simulated = is_simulated(state);
        Tick tick;
        tick.time_s = since_begin_s(timeline_.simulated ? state.utime : utime);
        tick.seq = state.seq;
        std::copy_n(state.position_m, 3, tick.finger_m.begin());
        side.ticks.push_back(tick);
    }

    void add(const servo_force& force, std::int64_t utime, Side& side) {
        const Open* const asked = side.open.find(force);
        if (asked == nullptr || force.owner != force.session || side.ticks[asked->tick].answered) return;
        Tick* const tick = &side.ticks[asked->tick];
        timeline_.tables_hash = static_cast<std::uint64_t>(force.model_hash);
        tick->answered = true;
        tick->servo_state = force.servo_state;
        std::copy_n(force.force_n, 3, tick->force_n.begin());
        // In lockstep the answer has the servo's time, which a second device's is not.
        if (timeline_.simulated)
            tick->time_s = since_begin_s(force.utime);
        else
            tick->latency_us = static_cast<double>(utime - asked->utime);
        account(*tick, asked->tick, side);
    }

    /// The force before this one was held until now (Hannaford and Ryu 2002).
    static void account(Tick& tick, std::size_t index, Side& side) {
        for (std::size_t axis = 0; side.held && axis < 3; ++axis)
            side.given_j +=
                side.ticks[*side.held].force_n[axis] * (tick.finger_m[axis] - side.ticks[*side.held].finger_m[axis]);
        tick.given_j = side.given_j;
        const bool acts = tick.servo_state == servo_force::CONTACT || tick.servo_state == servo_force::LIMITED ||
                          tick.servo_state == servo_force::FREE;
        side.held = acts ? std::optional(index) : std::nullopt;
    }

    void add(const contact& touched, Side& side) const {
        const Open* const asked = side.open.find(touched);
        if (asked == nullptr) return;
        Tick* const tick = &side.ticks[asked->tick];
        std::copy_n(touched.god_object_m, 3, tick->god_object_m.begin());
        const BodyFrame::Dent dent = body_.dent_of(touched);
        tick->depth_m = dent.depth_m;
        tick->stored_j = dent.stored_j;
    }

    void add(const servo_status& status, const Side& side) {
        StatusPoint point;
        point.time_s = side.ticks.empty() ? 0.0 : side.ticks.back().time_s;
        for (std::size_t i = 0; i < status.name.size(); ++i) point.counters[status.name[i]] = status.value[i];
        timeline_.statuses.push_back(std::move(point));
    }

    Timeline timeline_;
    std::array<Side, kFingers> side_;
    BodyFrame body_;
    std::optional<std::int64_t> begin_;
};

void append(double value, std::string& line) {
    line += ',';
    if (!std::isnan(value)) fmt::format_to(std::back_inserter(line), "{:.9g}", value);
}

void append(const Tick& tick, std::string& text) {
    fmt::format_to(std::back_inserter(text), "{:.6f},{}", tick.time_s, tick.seq);
    for (const double x_m : tick.finger_m) fmt::format_to(std::back_inserter(text), ",{:.9g}", x_m);
    text += ',';
    if (tick.answered) text += std::to_string(tick.servo_state);
    for (const double x_m : tick.god_object_m) append(x_m, text);
    for (const double x_n : tick.force_n) append(x_n, text);
    for (const double value : {tick.depth_m, tick.latency_us, tick.stored_j, tick.given_j}) append(value, text);
}

}  // namespace

double Tick::force_size_n() const { return std::hypot(force_n[0], force_n[1], force_n[2]); }

Timeline read_timeline(const std::filesystem::path& log) {
    LogReader events(log);
    Reader reader;
    while (const auto event = events.next()) reader.take(*event);
    return reader.finish(events.damaged());
}

void write_csv(const Timeline& timeline, const std::filesystem::path& file) {
    const bool has_more = !timeline.others.empty();
    std::string text =
        "time_s,seq,x,y,z,servo_state,god_x,god_y,god_z,force_x,force_y,force_z,depth_m,latency_us,"
        "energy_stored_j,energy_given_j";
    text += has_more ? ",finger\n" : "\n";
    std::vector<std::pair<const Tick*, std::size_t>> rows;
    for (const Tick& tick : timeline.ticks) rows.emplace_back(&tick, 1);
    for (std::size_t i = 0; i < timeline.others.size(); ++i)
        for (const Tick& tick : timeline.others[i]) rows.emplace_back(&tick, i + 2);
    std::stable_sort(rows.begin(), rows.end(),
                     [](const auto& a, const auto& b) { return a.first->time_s < b.first->time_s; });
    for (const auto& [tick, finger] : rows) {
        append(*tick, text);
        text += has_more ? fmt::format(",{}\n", finger) : "\n";
    }
    write_file(file, text);
}

}  // namespace haptable
