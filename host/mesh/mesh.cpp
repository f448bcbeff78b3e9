// SPDX-License-Identifier: GPL-2.0-or-later
// 6 V = det(p1 - p0, p2 - p0, p3 - p0)
#include "host/mesh/mesh.hpp"

#include <Eigen/Geometry>

namespace haptable {

double six_volumes(const std::vector<Eigen::Vector3d>& position_m, const Tet& tet) {
    const auto edge = [&](std::size_t c) -> Eigen::Vector3d {
        return position_m[static_cast<std::size_t>(tet[c])] - position_m[static_cast<std::size_t>(tet[0])];
    };
    return edge(1).dot(edge(2).cross(edge(3)));
}

}  // namespace haptable
