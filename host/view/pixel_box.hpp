// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace haptable {

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
