// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/counts.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/haptable_model.h"

namespace haptable {

namespace {

Counts summarise(std::vector<std::uint64_t> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const std::size_t last = values.size() - 1;
    return {values.size(), values[last / 2], values[(last * 999 + 999) / 1000], values[last]};
}

/// The farthest that a finger came.
template <std::size_t size>
double motion_m(const TargetPath<size>& path_m, std::size_t tick) {
    double most_m = 0.0;
    for (std::size_t f = 0; tick > 0 && f < size; f += 3) {
        const float *from = &path_m[tick - 1][f], *to = &path_m[tick][f];
        most_m = std::max(most_m, std::hypot(double(to[0]) - double(from[0]), double(to[1]) - double(from[1]),
                                             double(to[2]) - double(from[2])));
    }
    return most_m;
}

}  // namespace

template <std::size_t size>
TickCounts count_ticks(const TargetPath<size>& path_m, const std::vector<TargetTick>& ticks) {
    std::vector<std::uint64_t> of[2][2], jumps;  // [contact before][contact after]
    bool before = false;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const bool after = ticks[i].touches(size / 3);
        const bool jump = !(before && after) && motion_m(path_m, i) > static_cast<double>(HAPTABLE_FAST_SEGMENT_M);
        (jump ? jumps : of[before ? 1 : 0][after ? 1 : 0]).push_back(ticks[i].instructions);
        before = after;
    }
    return {summarise(of[0][0]), summarise(of[0][1]), summarise(of[1][1]), summarise(of[1][0]), summarise(jumps)};
}

template TickCounts count_ticks(const TargetPath<3>& path_m, const std::vector<TargetTick>& ticks);
template TickCounts count_ticks(const TargetPath<6>& path_m, const std::vector<TargetTick>& ticks);

}  // namespace haptable
