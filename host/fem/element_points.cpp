// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/element_points.hpp"

#include <Eigen/Dense>

namespace haptable {

std::vector<ElementPoint> points_of(const ElementMesh& mesh, std::size_t t) {
    if (!mesh.is_quadratic()) {  // the same everywhere
        const TetGeometry g = tet_geometry(corners_of(mesh, t));
        return {{g.volume_m3, Eigen::Vector4d::Constant(0.25), g.gradient_per_m}};
    }
    std::vector<ElementPoint> points;
    const TenNodes node_m = ten_nodes_of(mesh, t);
    for (const Eigen::Vector4d& at : tet_points()) {
        const auto [det, gradient] = tet_point(node_m, at);
        points.push_back({det / 24.0, at, gradient});
    }
    return points;
}

Eigen::Matrix3Xd moves_of(const std::vector<std::int32_t>& nodes, const Eigen::Matrix3Xd& u) {
    Eigen::Matrix3Xd moves(3, static_cast<Eigen::Index>(nodes.size()));
    for (std::size_t b = 0; b < nodes.size(); ++b) moves.col(static_cast<Eigen::Index>(b)) = u.col(nodes[b]);
    return moves;
}

Eigen::Matrix3d gradient_of(const Eigen::Matrix3Xd& moves, const ElementPoint& point) {
    return moves.lazyProduct(point.gradient_per_m.transpose());  // too small for a product by blocks
}

Eigen::Matrix3d cofactor(const Eigen::Matrix3d& f) {
    Eigen::Matrix3d cof;
    for (Eigen::Index c = 0; c < 3; ++c) cof.col(c) = f.col((c + 1) % 3).cross(f.col((c + 2) % 3));
    return cof;
}

}  // namespace haptable
