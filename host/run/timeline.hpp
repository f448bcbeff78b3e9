// SPDX-License-Identifier: GPL-2.0-or-later
// A session's log as a table: one row a state, with the servo's answer, and the servo's counters over time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace haptable {

struct Tick {
    static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

    double time_s = 0.0;  ///< since the first state: of the log's clock, in lockstep of the simulated one
    std::int64_t seq = 0;
    std::array<double, 3> finger_m{};
    bool answered = false;
    int servo_state = -1;  ///< of the answer, as in servo_force
    std::array<double, 3> force_n{kNone, kNone, kNone}, god_object_m{kNone, kNone, kNone};
    double latency_us = kNone;  ///< from state to answer, as both were heard; none in lockstep
    double depth_m = kNone;     ///< from the god-object to the finger
    double stored_j = kNone;    ///< 1/2 u . f of the loads, as servo_status has it
    double given_j = kNone;     ///< by the forces so far

    double force_size_n() const;
};

struct StatusPoint {
    double time_s = 0.0;
    std::map<std::string, std::int64_t> counters;
};

struct Timeline {
    std::vector<Tick> ticks;
    std::vector<std::vector<Tick>> others;  ///< of fingers 2 and on
    std::vector<StatusPoint> statuses;
    std::int64_t damaged = 0;  ///< stretches of the log, and messages in it, that could not be read
    bool simulated = false;
    std::uint64_t tables_hash = 0;  ///< of the servo that answered; 0: none did
};

/// Throws Error where there is no log. A log that was cut off is read up to there.
Timeline read_timeline(const std::filesystem::path& log);

/// One line a tick, where there are more fingers in the order of their times with the finger's number at the end;
/// floats as the servo's CSV has them, empty where there is no answer. Throws Error.
void write_csv(const Timeline& timeline, const std::filesystem::path& file);

}  // namespace haptable
