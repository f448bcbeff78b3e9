// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/stage_clock.hpp"

#include <utility>

namespace haptable {

void StageClock::begin(const std::string& stage) {
    end();
    progress_.stage(stage);
    running_ = stage;
    begin_ = std::chrono::steady_clock::now();
    cpu_begin_s_ = process_cost().cpu_s;
}

const std::vector<StageCost>& StageClock::end() {
    if (running_.empty()) return stages_;
    const ProcessCost now = process_cost();
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin_;
    stages_.push_back({std::exchange(running_, ""), time.count(), now.cpu_s - cpu_begin_s_, now.peak_bytes});
    return stages_;
}

}  // namespace haptable
