// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
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

/// A box of pixels; empty as made.
struct PixelBox {
    float left = 1e9F, top = 1e9F, right = -1e9F, bottom = -1e9F;

    void include(const Eigen::Vector2f& centre, float radius) {
        left = std::min(left, centre.x() - radius);
        right = std::max(right, centre.x() + radius);
        top = std::min(top, centre.y() - radius);
        bottom = std::max(bottom, centre.y() + radius);
    }
};

}  // namespace haptable
