// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/cube.hpp"

#include <utility>

namespace haptable {

namespace {

/// Turns a tetrahedron that stands the other way round.
Tet turned(const std::vector<Eigen::Vector3d>& position_m, Tet tet) {
    if (six_volumes(position_m, tet) < 0.0) std::swap(tet[2], tet[3]);
    return tet;
}

}  // namespace

TetMesh make_cube(int nodes_per_side, double side_m) {
    const int n = nodes_per_side;
    TetMesh mesh;
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) mesh.position_m.push_back(Eigen::Vector3d(x, y, z) * side_m / (n - 1));

    // A cell has 8 corners; bit 0, 1, 2 of a corner's number is its place in x, y, z. Four corners, no two of them on
    // one edge, are cut off by a tetrahedron each; the fifth tetrahedron has the other four.
    for (int z = 0; z + 1 < n; ++z)
        for (int y = 0; y + 1 < n; ++y)
            for (int x = 0; x + 1 < n; ++x) {
                const auto node = [&](int corner) {
                    return (x + (corner & 1)) + n * ((y + (corner >> 1 & 1)) + n * (z + (corner >> 2)));
                };
                // Mirroring a cell in any axis changes which four corners are cut off.
                const int mirror = (x + y + z) % 2 == 0 ? 0 : 1;
                for (int cut : {0, 3, 5, 6}) {
                    const int c = cut ^ mirror;
                    mesh.tet.push_back(turned(mesh.position_m, {node(c), node(c ^ 1), node(c ^ 2), node(c ^ 4)}));
                }
                mesh.tet.push_back(
                    turned(mesh.position_m, {node(1 ^ mirror), node(2 ^ mirror), node(4 ^ mirror), node(7 ^ mirror)}));
            }
    return mesh;
}

}  // namespace haptable
