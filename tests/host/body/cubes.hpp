// SPDX-License-Identifier: GPL-2.0-or-later
// Cubes that nothing holds, what tests of them select, and each of the elements.
#pragma once

#include <string>

#include "host/scene/scene.hpp"

namespace haptable::test {

inline constexpr double kCubeSide_m = 0.03;
inline constexpr Element kElements[] = {Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic};

inline Selection box(double x0, double y0, double z0, double x1, double y1, double z1) {
    return {std::array<double, 6>{x0, y0, z0, x1, y1, z1}, "", 1};
}

inline Scene cube_of(const std::string& name, int nodes_per_side, const Material& material,
                     Element element = Element::kLinear) {
    Scene scene;
    scene.file = name + ".toml";
    scene.name = name;
    scene.mesh.generate = "cube";
    scene.mesh.nodes_per_side = nodes_per_side;
    scene.mesh.side_m = kCubeSide_m;
    scene.mesh.element = element;
    scene.material = material;
    return scene;
}

}  // namespace haptable::test
