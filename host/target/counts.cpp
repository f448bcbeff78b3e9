// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/counts.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/haptable.h"

namespace haptable {

namespace {

Counts summarise(std::vector<std::uint64_t> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const std::size_t last = values.size() - 1;
    return {values.size(), values[last / 2], values[(last * 999 + 999) / 1000], values[last]};
}

double motion_m(const std::vector<std::array<float, 3>>& path_m, std::size_t tick) {
    if (tick == 0) return 0.0;
    const auto &from = path_m[tick - 1], &to = path_m[tick];
    return std::hypot(double(to[0]) - double(from[0]), double(to[1]) - double(from[1]),
                      double(to[2]) - double(from[2]));
}

}  // namespace

TickCounts count_ticks(const std::vector<std::array<float, 3>>& path_m, const std::vector<TargetTick>& ticks) {
    std::vector<std::uint64_t> of[2][2], jumps;  // [contact before][contact after]
    bool before = false;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const bool after = haptable_touches(static_cast<int>(ticks[i].state)) != 0;
        const bool jump = !(before && after) && motion_m(path_m, i) > static_cast<double>(HAPTABLE_FAST_SEGMENT_M);
        (jump ? jumps : of[before ? 1 : 0][after ? 1 : 0]).push_back(ticks[i].instructions);
        before = after;
    }
    return {summarise(of[0][0]), summarise(of[0][1]), summarise(of[1][1]), summarise(of[1][0]), summarise(jumps)};
}

}  // namespace haptable
