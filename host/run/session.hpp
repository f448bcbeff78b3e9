// SPDX-License-Identifier: GPL-2.0-or-later
// A whole session: servo (or target and bridge), device, viewer and log, started and ended together.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/run/places.hpp"

namespace haptable {

inline constexpr std::size_t kMostEvents = 500;

struct RunOptions {
    std::filesystem::path scene_file, folder;
    std::vector<std::string> device;  ///< words of haptable-device behind its scene
    std::string target;               ///< empty: the servo is the host's
    bool live = false;                ///< draw while it runs
    int every_ms = 100;               ///< from picture to picture
    bool no_realtime = false, quiet = false;
};

/// What servo, bridge or device told its user.
struct ToldEvent {
    double time_s = 0.0;  ///< since the session's begin, by the clock of the wall
    std::string text;
};

/// What became of a session, whatever ended it.
struct RunOutcome {
    std::string device_summary, servo_summary;  ///< JSON, as the programs print it; empty where they did not
    std::vector<ToldEvent> events;              ///< the first of them: kMostEvents
    std::int64_t more_events = 0;               ///< that came later
    double wall_s = 0.0;
    bool interrupted = false;
    std::string trouble;  ///< what ended it before its time; empty: nothing
};

/// Runs it until the device's end, Ctrl-C, the death of a program or a full disk. Afterwards no program of it runs, and
/// the folder has session.lcmlog, servo.csv and device.csv, whole up to there. Throws Error where it cannot begin.
RunOutcome run_session(const Places& places, const RunOptions& options);

}  // namespace haptable
