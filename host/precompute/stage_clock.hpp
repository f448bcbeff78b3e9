// SPDX-License-Identifier: GPL-2.0-or-later
// What the stages of a run take.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "host/base/process_cost.hpp"
#include "host/base/progress.hpp"

namespace haptable {

struct StageCost {
    std::string name;
    double time_s = 0.0;
    double cpu_s = 0.0;       ///< of all threads
    double peak_bytes = 0.0;  ///< largest resident set so far, at the stage's end
};

/// Names each stage to a progress bar and measures it.
class StageClock {
public:
    explicit StageClock(Progress& progress) : progress_(progress) {}
    /// Ends the stage before.
    void begin(const std::string& stage);
    /// The stages that have ended, in order; this one with them.
    const std::vector<StageCost>& end();

private:
    Progress& progress_;
    std::vector<StageCost> stages_;
    std::string running_;  // or empty
    std::chrono::steady_clock::time_point begin_;
    double cpu_begin_s_ = 0.0;
};

}  // namespace haptable
