// SPDX-License-Identifier: GPL-2.0-or-later
// W(F) = mu/2 w(x) + kappa/2 (J - 1)^2,   x = J^-2/3 tr F^T F - 3,   F = I + grad u,   J = det F
//
// A body that stiffens: its energy and what its nodes resist any displacement with. For small ones it is the scene's
// linear body. Elements are the linear body's own, with what they average (host/fem/stiffness.hpp): there theta_a is
// the mean of J - 1, weighted by N_a. CalculiX and Abaqus call it *HYPERELASTIC, YEOH with C10 = mu/2, C20 = mu/2 y_2,
// C30 = mu/2 y_3 and D1 = 2/kappa.
#pragma once

#include <vector>

#include "host/base/stiffening.hpp"
#include "host/fem/element_points.hpp"
#include "host/fem/nodal_pressure.hpp"

namespace haptable {

class Hyperelastic {
public:
    /// What the mesh's spans are of must outlive this. Its materials are isotropic.
    Hyperelastic(const ElementMesh& mesh, const Stiffening& stiffening);

    /// W, J, of displacements u, [3, N] m, and its gradient, N, [3, N]. Infinite where an element is turned over.
    double energy(const Eigen::Matrix3Xd& u, Eigen::Matrix3Xd& force_n) const;

private:
    /// [cells] (lambda - lambda_e) theta_a, Pa; returns what they store.
    double nodal_pressures(const Eigen::Matrix3Xd& u, Eigen::VectorXd& pressure_pa) const;

    ElementMesh mesh_;
    Stiffening stiffening_;
    std::vector<std::vector<std::int32_t>> nodes_;    // [T]
    std::vector<std::vector<ElementPoint>> points_;   // [T]
    std::size_t cell_count_ = 0;                      // 0: nothing is averaged
    std::vector<std::array<std::int32_t, 4>> cells_;  // [T] of its corners
    std::vector<double> cell_volume_m3_, left_pa_;    // [cells] V_a; lambda - lambda_e
};

}  // namespace haptable
