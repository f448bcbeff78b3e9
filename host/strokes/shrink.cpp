// SPDX-License-Identifier: GPL-2.0-or-later
// Delta debugging (Zeller and Hildebrandt 2002), with runs of ticks that are left out
#include "host/strokes/shrink.hpp"

#include <algorithm>

namespace haptable {

namespace {

/// How far the finger went that moved more, m.
double motion_m(const FingerPositions& a, const FingerPositions& b) {
    return std::max((to_vector(b[0].data()) - to_vector(a[0].data())).norm(),
                    (to_vector(b[1].data()) - to_vector(a[1].data())).norm());
}

double longest_motion_m(const Stroke& stroke) {
    double longest = 0.0;
    for (std::size_t i = 1; i < stroke.size(); ++i) longest = std::max(longest, motion_m(stroke[i - 1], stroke[i]));
    return longest;
}

Stroke without(const Stroke& stroke, std::size_t begin, std::size_t count) {
    Stroke rest = stroke;
    const auto first = rest.begin() + static_cast<std::ptrdiff_t>(begin);
    rest.erase(first, first + static_cast<std::ptrdiff_t>(std::min(count, rest.size() - begin)));
    return rest;
}

}  // namespace

Stroke shrink(const Touched& touched, const Stroke& stroke, Fault fault) {
    const double most_m = std::max(longest_motion_m(stroke), static_cast<double>(HAPTABLE_FAST_SEGMENT_M));
    Stroke least = stroke;
    const auto cut = [&](const Verdict& verdict) {  // what comes after the fault is not needed
        least.resize(static_cast<std::size_t>(verdict.tick[static_cast<std::size_t>(fault)]) + 1);
    };
    cut(judge(touched, least));
    for (std::size_t count = least.size() / 2; count > 0; count /= 2)
        for (std::size_t begin = 0; begin < least.size();) {
            Stroke tried = without(least, begin, count);
            const bool is_slow = !tried.empty() && longest_motion_m(tried) <= most_m;
            const Verdict verdict = is_slow ? judge(touched, tried) : Verdict();
            if (!verdict.has(fault)) {
                begin += count;
                continue;
            }
            least = std::move(tried);
            cut(verdict);
        }
    return least;
}

}  // namespace haptable
