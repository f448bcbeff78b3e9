// SPDX-License-Identifier: GPL-2.0-or-later
// What tests of cubes select: boxes, and each of the elements.
#pragma once

#include "host/scene/scene.hpp"

namespace haptable::test {

inline constexpr double kCubeSide_m = 0.03;
inline constexpr Element kElements[] = {Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic};

inline Selection box(double x0, double y0, double z0, double x1, double y1, double z1) {
    return {std::array<double, 6>{x0, y0, z0, x1, y1, z1}, "", 1};
}

}  // namespace haptable::test
