// SPDX-License-Identifier: GPL-2.0-or-later
// A cube of tetrahedra that differ.
#pragma once

#include <random>

#include "host/mesh/cube.hpp"
#include "host/mesh/middles.hpp"
#include "host/scene/scene.hpp"

namespace haptable::test {

inline bool is_inside_cube(const Eigen::Vector3d& p, double side) { return p.minCoeff() > 0.0 && p.maxCoeff() < side; }

/// A cube whose inner corners are moved by up to 15 % of an edge.
inline TetMesh jittered_cube(int n, double side, Element element = Element::kLinear) {
    TetMesh mesh = make_cube(n, side);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> shift(-0.15 * side / (n - 1), 0.15 * side / (n - 1));
    for (Eigen::Vector3d& p : mesh.position_m)
        if (is_inside_cube(p, side)) p += Eigen::Vector3d(shift(random), shift(random), shift(random));
    if (element == Element::kQuadratic) add_middles(mesh);
    return mesh;
}

}  // namespace haptable::test
