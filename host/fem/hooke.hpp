// SPDX-License-Identifier: GPL-2.0-or-later
// stress = D strain,   strain = (xx, yy, zz, 2 xy, 2 xz, 2 yz),   W = 1/2 strain^T D strain
//
// Hooke's law without symmetry, in Voigt's notation.
#pragma once

#include <Eigen/Core>
#include <array>

#include "host/fem/elasticity.hpp"

namespace haptable {

using Hooke = Eigen::Matrix<double, 6, 6>;     ///< D, Pa: symmetric positive definite
using Voigt = Eigen::Matrix<double, 6, 1>;     ///< strain or stress
using Gradient = Eigen::Matrix<double, 3, 3>;  ///< of a displacement: d u_i / d x_j

/// In the material's own directions. poisson: nu_12 nu_13 nu_23; shear: G_12 G_13 G_23.
Hooke orthotropic_hooke(const std::array<double, 3>& young_pa, const std::array<double, 3>& poisson,
                        const std::array<double, 3>& shear_pa);
Hooke isotropic_hooke(const Lame& material);

/// The law of a material that lies along `axes`: columns are its directions 1, 2, 3, a right-handed frame.
Hooke turned(const Hooke& own, const Eigen::Matrix3d& axes);

/// The strain of a displacement's gradient.
Voigt strain_of(const Gradient& gradient);
/// As a symmetric matrix.
Eigen::Matrix3d stress_of(const Voigt& stress);

/// The element's stiffness, N/m: 3 rows a node. Symmetric to the last bit.
Eigen::Matrix<double, 12, 12> element_stiffness(const TetGeometry& geometry, const Hooke& law);
/// Integrated by tet_points().
Eigen::Matrix<double, 30, 30> element_stiffness(const TenNodes& node_m, const Hooke& law);

}  // namespace haptable
