// SPDX-License-Identifier: GPL-2.0-or-later
// A record through the servo, with no clock: time is the record's.
#pragma once

#include <filesystem>
#include <optional>

#include "host/session/local_stepper.hpp"
#include "host/session/scene.hpp"
#include "host/session/servo/recording.hpp"

namespace haptable {

struct ReplayReport : ServoReport {
    std::int64_t compared = 0;             ///< ticks whose force the record has
    std::int64_t other_forces = 0;         ///< of these, whose force is another now, be it in one bit
    std::int64_t first_other = -1;         ///< number of the first of them
    std::vector<ServoReport> others = {};  ///< of fingers 2 and on
    double most_given_j = 0.0;             ///< to both hands together, the largest so far
};

/// Steps the servo through a recording and writes its CSV to `out`, whole or not at all; nothing where `out` is empty.
ReplayReport replay(const ServoScene& scene, const Recording& recording, const std::filesystem::path& out, bool quiet);

/// The same with what `in` holds.
ReplayReport replay(const ServoScene& scene, const std::filesystem::path& in, const std::filesystem::path& out,
                    bool quiet);

}  // namespace haptable
