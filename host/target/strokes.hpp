// SPDX-License-Identifier: GPL-2.0-or-later
// A finger path that visits a whole body: the fixed path of the instruction counts, and what a target replays.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/tables/tables.hpp"

namespace haptable {

/// Strokes of 40 ticks over the touchable surface, [40 strokes, 3] in metres: above a patch, down into it, straight
/// through the body's near side to another patch not far away (over edges, vertices and creases), out. Between
/// strokes the finger jumps, so some first contacts' segments cross the whole body. The same for the same tables.
std::vector<std::array<float, 3>> stroke_path(const Tables& tables, int strokes);

/// How far the finger comes that goes farthest.
template <std::size_t size>
float way_m(const std::array<float, size>& from_m, const std::array<float, size>& to_m) {
    float most_m = 0.0F;
    for (std::size_t f = 0; f < size; f += 3)
        most_m =
            std::max(most_m, std::hypot(to_m[f] - from_m[f], to_m[f + 1] - from_m[f + 1], to_m[f + 2] - from_m[f + 2]));
    return most_m;
}

/// A path with ticks between its own, so that no finger's motion is longer; 4 mm: what a servo with max_speed believes.
template <std::size_t size>
std::vector<std::array<float, size>> walked(const std::vector<std::array<float, size>>& path_m,
                                            float longest_m = 0.004F) {
    std::vector<std::array<float, size>> path;
    for (const auto& to_m : path_m) {
        const std::array<float, size> from_m = path.empty() ? to_m : path.back();
        const int steps = static_cast<int>(std::ceil(way_m(from_m, to_m) / longest_m));
        for (int i = 1; i < steps; ++i) {
            std::array<float, size> at_m;
            for (std::size_t c = 0; c < size; ++c)
                at_m[c] = from_m[c] + static_cast<float>(i) / static_cast<float>(steps) * (to_m[c] - from_m[c]);
            path.push_back(at_m);
        }
        path.push_back(to_m);
    }
    return path;
}

/// Strokes of two fingers: the second's are those of the first in another order, so that both are always in the same
/// part of a stroke.
std::vector<std::array<float, 6>> of_two(const std::vector<std::array<float, 3>>& path_m, int strokes);

/// A tool whose handle takes that path and turns on it, as TargetImage::measure takes a tool's.
std::vector<std::array<float, 6>> poses_of(const std::vector<std::array<float, 3>>& path_m);

/// The strokes of the contact tests, [20 strokes, 3] in metres: a position that is none (the servo forgets the finger),
/// then from just outside of a random patch straight inwards for 10 ticks, then for 9 aside, at 0.01 to 5 m/s, whatever
/// stands in the way: over edges, through thin parts, in and out. The same for the same tables. No step is longer than
/// 5 mm.
std::vector<std::array<float, 3>> hard_path(const Tables& tables, int strokes);

/// Sessions of a cube of 30 mm that stands on a floor or is held there, a corner at the origin, in metres.
/// Down onto the middle of its top, and along it: where nothing holds the cube, friction tips it over an edge. Then
/// what is no position.
std::vector<std::array<float, 3>> tip_path();
/// Two fingers grasp it, lift it by 20 mm, hold it, and let it fall; one is no position for a tick.
std::vector<std::array<float, 6>> grasp_path();
/// Three knocks on its top, a slide at depth, and what is no position.
std::vector<std::array<float, 3>> knock_path();
/// Two fingers squeeze its sides and let go, one after the other presses on its top, and they slide apart; one is no
/// position for a tick.
std::vector<std::array<float, 6>> squeeze_path();

}  // namespace haptable
