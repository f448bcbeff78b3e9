// SPDX-License-Identifier: GPL-2.0-or-later
// N_c = t_c (2 t_c - 1),   N_ab = 4 t_a t_b,   x(t) = sum of N x over ten nodes,   sum t = 1
//
// The tetrahedron with nodes in the middle of its edges: of its shape as of its displacements.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace haptable {

/// The edges of a tetrahedron in the order of their middle nodes: VTK's, Abaqus' and CalculiX's.
inline constexpr std::array<std::array<std::size_t, 2>, 6> kTetEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

/// Where ten nodes are, m: the corners, then the middles of kTetEdges.
using TenNodes = Eigen::Matrix<double, 3, 10>;
TenNodes ten_nodes(std::span<const Eigen::Vector3d> position_m, const std::array<std::int32_t, 4>& corner,
                   const std::array<std::int32_t, 6>& middle);

/// One value of each of the ten shape functions' gradients, 1/m.
using TenGradients = Eigen::Matrix<double, 3, 10>;

/// N at the barycentric coordinates t.
Eigen::Vector<double, 10> ten_values(const Eigen::Vector4d& t);

/// What the element is around one of its points.
struct TetPoint {
    double det_m3 = 0.0;  ///< of dx/dt: six times the volume of a straight element; not positive where it is folded
    TenGradients gradient_per_m;
};
/// t: barycentric coordinates of the point.
TetPoint tet_point(const TenNodes& node_m, const Eigen::Vector4d& t);

/// An integral over the element is the sum over these points of the value times det / 24: exact for polynomials of
/// degree 2 (Keast 1986); CalculiX's points of C3D10.
std::array<Eigen::Vector4d, 4> tet_points();

/// det at those points: the least and the greatest.
struct DetRange {
    double least_m3 = 0.0, greatest_m3 = 0.0;
};
DetRange det_range(const TenNodes& node_m);

}  // namespace haptable
