// SPDX-License-Identifier: GPL-2.0-or-later
// What is made of a session's record when it is over: CSV, pictures or film, page and summary.
#pragma once

#include <string>

#include "host/base/summary_lines.hpp"
#include "host/run/session.hpp"

namespace haptable {

/// Writes session.csv, report.html and the summaries into the session's folder, and as `draw` says: pictures (the
/// folder pictures/), film (session.mp4), nothing, or live: they are there. Where something cannot be made, the
/// summary's `trouble` says so and the rest is made all the same.
SummaryLines report(const Places& places, const RunOptions& options, const std::string& scene,
                    const RunOutcome& outcome, const std::string& draw);

}  // namespace haptable
