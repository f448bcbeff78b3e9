// SPDX-License-Identifier: GPL-2.0-or-later
// Where an element is integrated, and how its nodes move.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "host/fem/stiffness.hpp"

namespace haptable {

/// A point of integration of an element, of its ten nodes or of its four.
struct ElementPoint {
    double volume_m3;           ///< that it stands for
    Eigen::Vector4d of_corner;  ///< the corners' linear shape functions
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 10> gradient_per_m;
};
/// Those of tetrahedron t; of a linear one a single point, for its gradients are the same everywhere.
std::vector<ElementPoint> points_of(const ElementMesh& mesh, std::size_t t);

/// u of an element's nodes: [3, 4 or 10].
Eigen::Matrix3Xd moves_of(const std::vector<std::int32_t>& nodes, const Eigen::Matrix3Xd& u);

/// grad u at a point of the element.
Eigen::Matrix3d gradient_of(const Eigen::Matrix3Xd& moves, const ElementPoint& point);

/// d det F / dF
Eigen::Matrix3d cofactor(const Eigen::Matrix3d& f);

}  // namespace haptable
