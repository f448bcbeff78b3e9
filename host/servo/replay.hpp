// SPDX-License-Identifier: GPL-2.0-or-later
// A recorded finger path through the servo, with no clock: a tick is a millisecond.
#pragma once

#include <filesystem>

#include "host/link/statistics.hpp"
#include "host/servo/energy.hpp"
#include "host/servo/scene.hpp"

namespace haptable {

/// What happened in a run, by replay or over LCM.
struct ServoReport {
    /// One tick: where the finger was, and what the servo answered.
    void note(const std::array<float, 3>& finger_m, const haptable_output& output);

    haptable_counters counters{};
    double largest_force_n = 0.0;
    EnergyAccount energy;
    DurationStatistics step;  ///< of haptable_step alone
};

/// Steps the servo through every position of `in` and writes its CSV to `out`, whole or not at all.
ServoReport replay(const ServoScene& scene, const std::filesystem::path& in, const std::filesystem::path& out,
                   bool quiet);

}  // namespace haptable
