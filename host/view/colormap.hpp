// SPDX-License-Identifier: GPL-2.0-or-later
// From 0 .. 1 to a colour, in equal steps for the eye.
#pragma once

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string_view>

namespace haptable {

using Rgb8 = std::array<std::uint8_t, 3>;  ///< sRGB

inline constexpr std::size_t kColors = 256;

/// Violet-blue over teal and green to yellow: lightness rises evenly, and neighbours are equally far apart in the
/// Oklab space, so that equal differences of displacement look equal, also in grey and to colour-blind eyes.
const std::array<Rgb8, kColors>& color_map();

/// What a thing is drawn in, 0xrrggbb: colors.inc.
struct DrawnColor {
    std::string_view name;
    std::uint32_t on_light, on_dark;
};
#define COLOR(name, on_light, on_dark) DrawnColor{#name, on_light, on_dark},
inline constexpr std::array kDrawnColors{
#include "host/view/colors.inc"
};
#undef COLOR

/// Of a picture's ground, which is light. A name that is not in colors.inc does not compile.
consteval Rgb8 drawn_color(std::string_view name) {
    for (const DrawnColor& color : kDrawnColors)
        if (color.name == name)
            return {static_cast<std::uint8_t>(color.on_light >> 16U), static_cast<std::uint8_t>(color.on_light >> 8U),
                    static_cast<std::uint8_t>(color.on_light)};
    throw std::logic_error("no such colour");
}

inline constexpr Rgb8 kNeutralColor = drawn_color("not_touchable");
inline constexpr Rgb8 kHeldColor = drawn_color("held");
inline constexpr std::array<Rgb8, 2> kFingerColor{drawn_color("finger"), drawn_color("second_finger")};
inline constexpr Rgb8 kGodObjectColor = drawn_color("god_object");
inline constexpr Rgb8 kArrowColor = drawn_color("force");
inline constexpr Rgb8 kTouchableColor{240, 217, 174};  ///< where no colour of the map is shown
inline constexpr Rgb8 kFaultColor{200, 30, 40};        ///< worst elements
inline constexpr Rgb8 kHingeColor{128, 40, 160};
inline constexpr Rgb8 kBackgroundColor{250, 250, 248};

}  // namespace haptable
