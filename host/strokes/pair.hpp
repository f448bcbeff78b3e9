// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers at once, each on a random stroke of its own: none may be lost, none may come through.
#pragma once

#include <functional>

#include "firmware/haptable_pair.h"
#include "host/base/workers.hpp"
#include "host/strokes/judge.hpp"

namespace haptable {

/// One body in one mode, for two. The pair's model is touched.model.
struct TouchedByTwo {
    const Touched& touched;
    const haptable_pair_model& pair;
};

/// What many pairs of strokes came to.
struct PairTally {
    std::size_t strokes = 0;  ///< pairs of them
    std::size_t ticks = 0, contact_ticks = 0;
    std::size_t both_ticks = 0;                    ///< both in contact
    std::size_t left_ticks = 0;                    ///< of these, the other's dent has left a finger behind
    std::size_t outside = 0, lost = 0, force = 0;  ///< strokes with such a fault
    std::vector<std::uint64_t> broken;             ///< their numbers

    void add(const PairTally& more);
};

/// Strokes number 2 n and 2 n + 1 of that seed at once, for n below `count`; the judge looks at either finger by turns.
/// Only faults count that the other finger does not explain: outside, lost, and a force that is none. The
/// result does not depend on the number of threads.
PairTally run_pairs(const TouchedByTwo& touched, const StrokeMaker& maker, std::uint64_t seed, std::size_t count,
                    Workers& workers, const std::function<void(std::size_t done)>& on_done);

}  // namespace haptable
