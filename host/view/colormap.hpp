// SPDX-License-Identifier: GPL-2.0-or-later
// From 0 .. 1 to a colour, in equal steps for the eye.
#pragma once

#include <array>

#include "host/base/colors.hpp"

namespace haptable {

inline constexpr std::size_t kColors = 256;

/// Violet-blue over teal and green to yellow: lightness rises evenly, and neighbours are equally far apart in the
/// Oklab space, so that equal differences of displacement look equal, also in grey and to colour-blind eyes.
const std::array<Rgb8, kColors>& color_map();

inline constexpr Rgb8 kNeutralColor = drawn_color("not_touchable");
inline constexpr Rgb8 kHeldColor = drawn_color("held");
inline constexpr std::array<Rgb8, 2> kFingerColor{drawn_color("finger"), drawn_color("second_finger")};
inline constexpr Rgb8 kGodObjectColor = drawn_color("god_object");
inline constexpr Rgb8 kArrowColor = drawn_color("force");
inline constexpr Rgb8 kTouchableColor = drawn_color("touchable");
inline constexpr Rgb8 kFaultColor = drawn_color("worst_element");
inline constexpr Rgb8 kHingeColor = drawn_color("hinge");
inline constexpr Rgb8 kBackgroundColor = drawn_color("picture_ground");

}  // namespace haptable
