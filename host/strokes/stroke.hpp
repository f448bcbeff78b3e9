// SPDX-License-Identifier: GPL-2.0-or-later
// Random fingers, one to eight at once, and a tool's poses: what hands do to a body, and what they should not be able
// to do.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"

namespace haptable {

/// Positions of the fingers in a tick, m, world coordinates, as the servo is given them; 0 of those that are not there.
/// Of a tool the handle's, and the vector part of its turn, whose scalar part is not negative.
using FingerPositions = std::array<std::array<float, 3>, HAPTABLE_HANDS>;
/// One a millisecond.
using Stroke = std::vector<FingerPositions>;

/// A stroke as the servo's CSV (docs/SPEC.md), to the bits of its floats; and back. fingers: 1 to 8, or kToolHand.
constexpr int kToolHand = 0;
std::string to_csv(const Stroke& stroke, int fingers);
Stroke read_stroke(const std::filesystem::path& file);

/// The whole turn, w x y z, of its vector part.
std::array<float, 4> turn_of(const std::array<float, 3>& vector);

/// Makes strokes over one surface. The same numbers give the same stroke.
class StrokeMaker {
public:
    explicit StrokeMaker(const ServoModel& servo);

    /// One of the kinds that docs/STROKES.md tells. Two fingers have the paths of the numbers 2 n and 2 n + 1, more
    /// those of 8 n and on; one that is done waits. In one of two strokes three fingers and more go together, beside
    /// the first.
    Stroke make(std::uint64_t seed, std::uint64_t number, int fingers) const;
    /// A tool, whose handle goes as one finger does, rolls, tilts and spins.
    Stroke make_poses(std::uint64_t seed, std::uint64_t number) const;

private:
    std::vector<std::array<float, 3>> path(std::uint64_t seed, std::uint64_t number) const;

    const ServoModel& servo_;
    double size_m_;
    std::vector<double> area_;  ///< [p] sums of the areas so far
};

}  // namespace haptable
