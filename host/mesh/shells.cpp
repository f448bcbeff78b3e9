// SPDX-License-Identifier: GPL-2.0-or-later
// 6 V = sum over the patches of a shell of a . (b x c)
#include "host/mesh/shells.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "host/mesh/sets.hpp"

namespace haptable {

Edges edges_of(const std::vector<Patch>& patches) {
    Edges edges;
    for (std::size_t p = 0; p < patches.size(); ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [low, high] = std::minmax(patches[p][c], patches[p][(c + 1) % 3]);
            edges[{low, high}].push_back(p);
        }
    return edges;
}

Shells find_shells(const TetMesh& mesh, const Surface& surface, const Edges& edges) {
    Sets sets(surface.patch.size());
    for (const auto& [edge, patches] : edges)
        for (std::size_t p : patches) sets.join(patches[0], p);
    Shells shells;
    shells.of_patch = sets.numbers();
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // far from the origin, digits would be lost
    for (std::int32_t i : surface.node)
        centre_m += mesh.position_m[static_cast<std::size_t>(i)] / static_cast<double>(surface.node.size());
    for (std::size_t p = 0; p < surface.patch.size(); ++p) {
        const auto corner = [&](std::size_t c) -> Eigen::Vector3d {
            return mesh.position_m[static_cast<std::size_t>(surface.patch[p][c])] - centre_m;
        };
        if (shells.of_patch[p] == shells.volume_m3.size()) shells.volume_m3.push_back(0.0);
        shells.volume_m3[shells.of_patch[p]] += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
    }
    return shells;
}

}  // namespace haptable
