// SPDX-License-Identifier: GPL-2.0-or-later
// From 0 .. 1 to a colour, in equal steps for the eye.
#pragma once

#include <array>
#include <cstdint>

namespace haptable {

using Rgb8 = std::array<std::uint8_t, 3>;  ///< sRGB

inline constexpr std::size_t kColors = 256;

/// Violet-blue over teal and green to yellow: lightness rises evenly, and neighbours are equally far apart in the
/// Oklab space, so that equal differences of displacement look equal, also in grey and to colour-blind eyes.
const std::array<Rgb8, kColors>& color_map();

inline constexpr Rgb8 kNeutralColor{218, 220, 223};    ///< parts that must not be touched
inline constexpr Rgb8 kHeldColor{172, 160, 143};       ///< parts that are held still
inline constexpr Rgb8 kTouchableColor{240, 217, 174};  ///< where no colour of the map is shown
inline constexpr Rgb8 kFaultColor{200, 30, 40};        ///< worst elements
inline constexpr Rgb8 kHingeColor{128, 40, 160};
inline constexpr Rgb8 kFingerColor{213, 94, 0};       ///< vermilion of Okabe and Ito's palette
inline constexpr Rgb8 kGodObjectColor{226, 60, 140};  ///< pink: far from every colour of the map
inline constexpr Rgb8 kArrowColor{34, 34, 40};
inline constexpr Rgb8 kBackgroundColor{250, 250, 248};

}  // namespace haptable
