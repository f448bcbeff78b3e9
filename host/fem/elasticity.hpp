// SPDX-License-Identifier: GPL-2.0-or-later
// The stiffness of one tetrahedron, linear or quadratic: small strain, isotropic.
#pragma once

#include <Eigen/Core>
#include <array>

#include "host/mesh/quadratic_tet.hpp"

namespace haptable {

/// A linear, isotropic material by its Lame constants: stress = lambda tr(strain) I + 2 mu strain.
struct Lame {
    double lambda_pa = 0.0;
    double mu_pa = 0.0;

    /// From Young's modulus > 0 and Poisson's ratio in (-1, 0.5).
    static Lame from_young(double young_pa, double poisson);
};

/// Corners of one tetrahedron, m, with det(p1-p0, p2-p0, p3-p0) > 0.
using Corners = std::array<Eigen::Vector3d, 4>;

/// Volume (m^3) and gradients of the four linear shape functions (column a: grad N_a, 1/m).
struct TetGeometry {
    double volume_m3 = 0.0;
    Eigen::Matrix<double, 3, 4> gradient_per_m;
};
TetGeometry tet_geometry(const Corners& corner_m);

/// The element's stiffness, N/m: 3 rows a corner. Symmetric to the last bit.
Eigen::Matrix<double, 12, 12> element_stiffness(const TetGeometry& geometry, const Lame& material);

/// Stiffness of ten nodes, its edges straight or curved; integrated by tet_points(), as CalculiX's C3D10.
Eigen::Matrix<double, 30, 30> element_stiffness(const TenNodes& node_m, const Lame& material);

}  // namespace haptable
