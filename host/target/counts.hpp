// SPDX-License-Identifier: GPL-2.0-or-later
// Instructions a tick, by what the tick does.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/target/image.hpp"

namespace haptable {

/// Instructions of the ticks of one kind.
struct Counts {
    std::size_t ticks = 0;
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
};

/// The ticks are those of the path. Contact is that of all its fingers, a jump that of any.
template <std::size_t size>
TickCounts count_ticks(const TargetPath<size>& path_m, const std::vector<TargetTick>& ticks);

}  // namespace haptable
