// SPDX-License-Identifier: GPL-2.0-or-later
// Instructions a tick, by what the tick does.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "host/target/image.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

/// Instructions of the ticks of one kind; 0 where there are none.
struct Counts {
    std::uint64_t median = 0;
    std::uint64_t p999 = 0;  ///< 99.9 % of the ticks take no more
    std::uint64_t worst = 0;
};

struct TickCounts {
    Counts free;           ///< no contact before, none after
    Counts first_contact;  ///< contact begun
    Counts sliding;        ///< contact before and after, of any length
    Counts leaving;        ///< contact before, none after
    Counts jump;  ///< farther than HAPTABLE_FAST_SEGMENT_M, as no hand moves, and begun or ended without contact
    std::array<std::size_t, 2> sliding_at{};  ///< the last ticks with the median and the worst count
};

/// The ticks are those of the path. Contact is that of all its fingers, a jump that of any.
template <std::size_t size>
TickCounts count_ticks(const TargetPath<size>& path_m, const std::vector<TargetTick>& ticks) {
    const auto instructions = [&](std::size_t tick) { return ticks[tick].instructions; };
    std::vector<std::size_t> of[2][2], jumps;  // [contact before][contact after]
    const auto summarise = [&](std::vector<std::size_t>& kind) -> Counts {
        if (kind.empty()) return {};
        std::ranges::stable_sort(kind, {}, instructions);
        const std::size_t last = kind.size() - 1;
        return {instructions(kind[last / 2]), instructions(kind[(last * 999 + 999) / 1000]), instructions(kind[last])};
    };
    bool before = false;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const bool after = ticks[i].touches(size / 3);
        const bool jump = !(before && after) && i > 0 && way_m(path_m[i - 1], path_m[i]) > HAPTABLE_FAST_SEGMENT_M;
        (jump ? jumps : of[before ? 1 : 0][after ? 1 : 0]).push_back(i);
        before = after;
    }
    TickCounts counts{summarise(of[0][0]), summarise(of[0][1]), summarise(of[1][1]), summarise(of[1][0]),
                      summarise(jumps)};
    if (const auto& sliding = of[1][1]; !sliding.empty())
        counts.sliding_at = {*--std::ranges::upper_bound(sliding, counts.sliding.median, {}, instructions),
                             sliding.back()};
    return counts;
}

}  // namespace haptable
