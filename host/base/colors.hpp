// SPDX-License-Identifier: GPL-2.0-or-later
// What a thing is drawn in, in pictures, films, pages and plots: colors.inc.
#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>

namespace haptable {

using Rgb8 = std::array<std::uint8_t, 3>;  ///< sRGB

/// What a thing is drawn in, 0xrrggbb.
struct DrawnColor {
    std::string_view name;
    std::uint32_t on_light, on_dark;
};
#define COLOR(name, on_light, on_dark) DrawnColor{#name, on_light, on_dark},
inline constexpr std::array kDrawnColors{
#include "host/base/colors.inc"
};
#undef COLOR

/// The colour on a light ground. A name that is not in colors.inc does not compile.
consteval Rgb8 drawn_color(std::string_view name) {
    for (const DrawnColor& color : kDrawnColors)
        if (color.name == name)
            return {static_cast<std::uint8_t>(color.on_light >> 16U), static_cast<std::uint8_t>(color.on_light >> 8U),
                    static_cast<std::uint8_t>(color.on_light)};
    throw std::logic_error("no such colour");
}

/// "#rrggbb", as pages and gnuplot have it.
inline std::string css(const Rgb8& color) {
    std::array<char, 8> text{};
    std::snprintf(text.data(), text.size(), "#%02x%02x%02x", color[0], color[1], color[2]);
    return text.data();
}

}  // namespace haptable
