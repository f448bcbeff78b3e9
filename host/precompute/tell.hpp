// SPDX-License-Identifier: GPL-2.0-or-later
// What a run tells people and scripts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/precompute/precompute.hpp"

namespace haptable {

struct Telling {
    std::string program;  ///< that speaks
    bool json = false;    ///< the summary as JSON on standard output instead of the table
    bool quiet = false;   ///< no table, no notes
};

/// "PROGRAM: kind: line" on standard error, for each line.
void say(const Telling& telling, const char* kind, const std::vector<std::string>& lines);

/// Notes, warnings and the summary of a run that wrote into `folder`, or found the same tables there.
void tell(const Telling& telling, const Scene& scene, const std::filesystem::path& folder, const Result& result);

}  // namespace haptable
