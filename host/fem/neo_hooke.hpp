// SPDX-License-Identifier: GPL-2.0-or-later
// W(F) = mu/2 (J^-2/3 tr F^T F - 3) + kappa/2 (J - 1)^2,   F = I + grad u,   J = det F
// f(t u) = f_1 t + f_2 t^2 + f_3 t^3 + ...,   f_1 = K u
//
// What the nodes of a neo-Hookean body resist a displacement with, as far as its third order: how a linear body's force
// begins to be wrong. The elements are the linear body's own, with what they average (host/fem/stiffness.hpp): there
// theta_a is the mean of J - 1, weighted by N_a. Integrals over quadratic tetrahedra are sums over tet_points(). The
// material is CalculiX's and Abaqus's NEO HOOKE with C10 = mu/2, D1 = 2/kappa.
#pragma once

#include <optional>
#include <span>

#include "host/fem/nodal_pressure.hpp"
#include "host/fem/stiffness.hpp"

namespace haptable {

/// Forces on N nodes, N: of the first, second and third order of a displacement.
struct ForceOrders {
    std::array<Eigen::Matrix3Xd, 3> force_n;  ///< [3, N] each
};

class NeoHooke {
public:
    /// What the mesh's spans are of must outlive this.
    explicit NeoHooke(const ElementMesh& mesh);

    /// u: [3, N] m.
    ForceOrders force_orders(const Eigen::Matrix3Xd& u) const;

private:
    using AtCorners = Eigen::Matrix<double, 4, 3>;
    /// [T] pressures, Pa, that an element has of its corners: by corner and order.
    std::vector<AtCorners> nodal_pressures(const Eigen::Matrix3Xd& u) const;

    ElementMesh mesh_;
    std::optional<NodalCells> cells_;
};

}  // namespace haptable
