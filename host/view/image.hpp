// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace haptable {

/// A picture, rows from the top, one 0x00RRGGBB a pixel (cairo's CAIRO_FORMAT_RGB24).
struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::uint32_t> pixel;  ///< [height, width]

    std::uint32_t at(int x, int y) const {
        return pixel[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

}  // namespace haptable
