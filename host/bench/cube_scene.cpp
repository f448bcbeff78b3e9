// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/cube_scene.hpp"

#include <fmt/format.h>

namespace haptable {

Scene cube_scene(int nodes_per_side, double poisson) {
    Scene scene;
    scene.file = "cube.toml";
    scene.name = fmt::format("cube{}-{:.0f}", nodes_per_side, 100.0 * poisson);
    scene.mesh.generate = "cube";
    scene.mesh.nodes_per_side = nodes_per_side;
    scene.material = {1e4, poisson};
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, 1e-9}, "", 1});
    return scene;
}

}  // namespace haptable
