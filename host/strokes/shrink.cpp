// SPDX-License-Identifier: GPL-2.0-or-later
// Delta debugging (Zeller and Hildebrandt 2002), with runs of ticks that are left out
#include <algorithm>
#include <functional>

#include "host/strokes/judge.hpp"

namespace haptable {

namespace {

/// How far each finger, or a tool's handle and its turn, go in a tick at the most.
std::array<double, HAPTABLE_HANDS> longest_motions(const Stroke& stroke) {
    std::array<double, HAPTABLE_HANDS> longest{};
    for (std::size_t i = 1; i < stroke.size(); ++i)
        for (std::size_t f = 0; f < longest.size(); ++f)
            longest[f] =
                std::max(longest[f], (to_vector(stroke[i][f].data()) - to_vector(stroke[i - 1][f].data())).norm());
    return longest;
}

bool is_slow(const Stroke& stroke, const std::array<double, HAPTABLE_HANDS>& most) {
    const auto longest = longest_motions(stroke);
    return !stroke.empty() && std::equal(longest.begin(), longest.end(), most.begin(), std::less_equal());
}

Stroke without(Stroke stroke, std::size_t begin, std::size_t count) {
    const auto first = stroke.begin() + static_cast<std::ptrdiff_t>(begin);
    stroke.erase(first, first + static_cast<std::ptrdiff_t>(std::min(count, stroke.size() - begin)));
    return stroke;
}

}  // namespace

Stroke shrink(const Touched& touched, const Stroke& stroke, Fault fault) {
    std::array<double, HAPTABLE_HANDS> most = longest_motions(stroke);
    for (double& longest : most) longest = std::max(longest, static_cast<double>(HAPTABLE_FAST_SEGMENT_M));
    Stroke least = stroke;
    const auto cut = [&](const Verdict& verdict) {  // what comes after the fault is not needed
        least.resize(static_cast<std::size_t>(verdict.tick[static_cast<std::size_t>(fault)]) + 1);
    };
    cut(judge(touched, least));
    for (std::size_t count = least.size() / 2; count > 0; count /= 2)
        for (std::size_t begin = 0; begin < least.size();) {
            Stroke tried = without(least, begin, count);
            const Verdict verdict = is_slow(tried, most) ? judge(touched, tried) : Verdict();
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
