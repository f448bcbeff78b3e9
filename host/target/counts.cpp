// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/counts.hpp"

#include <algorithm>

#include "firmware/haptable.h"

namespace haptable {

namespace {

Counts summarise(std::vector<std::uint64_t> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const std::size_t last = values.size() - 1;
    return {values.size(), values[last / 2], values[(last * 999 + 999) / 1000], values[last]};
}

}  // namespace

TickCounts count_ticks(const std::vector<TargetTick>& ticks) {
    std::vector<std::uint64_t> of[2][2];  // [contact before][contact after]
    bool before = false;
    for (const TargetTick& tick : ticks) {
        const bool after = tick.state == HAPTABLE_CONTACT;
        of[before ? 1 : 0][after ? 1 : 0].push_back(tick.instructions);
        before = after;
    }
    return {summarise(of[0][0]), summarise(of[0][1]), summarise(of[1][1]), summarise(of[1][0])};
}

}  // namespace haptable
