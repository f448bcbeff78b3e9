// SPDX-License-Identifier: GPL-2.0-or-later
// Many strokes over one body in one mode, on all threads.
#pragma once

#include <functional>
#include <vector>

#include "host/base/workers.hpp"
#include "host/strokes/stroked_body.hpp"

namespace haptable {

/// A stroke that broke something.
struct Broken {
    std::uint64_t number;
    Verdict verdict;
};

/// What became of the strokes over one body in one mode.
struct Tally {
    std::size_t strokes = 0, ticks = 0, contact_ticks = 0;
    std::size_t clamped = 0;                    ///< strokes that met max_force: their energy is judged until then
    std::size_t limits = 0;                     ///< of walks, slides and boxes
    std::array<std::size_t, kFaults> faulty{};  ///< strokes with each fault
    double most_given = 0.0;                    ///< least energy: given over stored, the worst stroke that met no clamp
    std::vector<Broken> broken;                 ///< ascending

    void add(std::uint64_t number, const Stroke& stroke, const Verdict& verdict);
    void add(const Tally& other);
};

/// Strokes number 0 .. count - 1 of that seed. The result does not depend on the number of threads.
/// on_done: strokes done so far, called from one thread at a time.
Tally run_strokes(const Touched& touched, const StrokeMaker& maker, std::uint64_t seed, std::size_t count,
                  Workers& workers, const std::function<void(std::size_t done)>& on_done);

}  // namespace haptable
