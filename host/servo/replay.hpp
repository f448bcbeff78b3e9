// SPDX-License-Identifier: GPL-2.0-or-later
// A recorded finger path through the servo, with no clock: a tick is a millisecond.
#pragma once

#include <filesystem>

#include "host/link/statistics.hpp"
#include "host/session/energy.hpp"
#include "host/session/scene.hpp"

namespace haptable {

/// What happened in a run, by replay or over LCM.
struct ServoReport : ForceReport {
    haptable_counters counters{};
    DurationStatistics step;  ///< of haptable_step alone
};

/// Steps the servo through every position of `in` and writes its CSV to `out`, whole or not at all.
ServoReport replay(const ServoScene& scene, const std::filesystem::path& in, const std::filesystem::path& out,
                   bool quiet);

}  // namespace haptable
