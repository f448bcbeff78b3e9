// SPDX-License-Identifier: GPL-2.0-or-later
// P(I + t H) = mu (J^-2/3 F - J^-5/3 tr(F^T F)/3 cof F) + (kappa (J - 1) + p) cof F
// J = 1 + j_1 t + j_2 t^2 + j_3 t^3,   cof F = I + (tr H I - H^T) t + cof H t^2
#include "host/fem/neo_hooke.hpp"

#include <Eigen/Dense>

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Orders = std::array<double, 3>;  // of t, t^2, t^3

Matrix3d cofactor(const Matrix3d& h) {
    Matrix3d cof;
    for (Eigen::Index c = 0; c < 3; ++c) cof.col(c) = h.col((c + 1) % 3).cross(h.col((c + 2) % 3));
    return cof;
}

/// J - 1
Orders volume_change(const Matrix3d& h) {
    const double trace = h.trace();
    return {trace, 0.5 * (trace * trace - (h * h).trace()), h.determinant()};
}

/// (1 + x)^p - 1
Orders power(const Orders& x, double p) {
    const double second = 0.5 * p * (p - 1.0), third = second * (p - 2.0) / 3.0;
    return {p * x[0], p * x[1] + second * x[0] * x[0],
            p * x[2] + 2.0 * second * x[0] * x[1] + third * x[0] * x[0] * x[0]};
}

/// P of an element under a pressure that is not its own, without it at t = 0.
std::array<Matrix3d, 3> stress(const Matrix3d& h, const Lame& own, const Orders& pressure_pa) {
    const Matrix3d one = Matrix3d::Identity(), first = h.trace() * one - h.transpose(), second = cofactor(h);
    const Orders j = volume_change(h), a = power(j, -2.0 / 3.0), b = power(j, -5.0 / 3.0);
    // tr F^T F / 3 = 1 + m_1 t + m_2 t^2
    const double m1 = 2.0 / 3.0 * h.trace(), m2 = h.squaredNorm() / 3.0;
    const Orders c{b[0] + m1, b[1] + b[0] * m1 + m2, b[2] + b[1] * m1 + b[0] * m2};
    const double kappa = own.lambda_pa + 2.0 / 3.0 * own.mu_pa;
    Orders p = pressure_pa;
    for (std::size_t k = 0; k < 3; ++k) p[k] += kappa * j[k];
    return {own.mu_pa * (a[0] * one + h - c[0] * one - first) + p[0] * one,
            own.mu_pa * (a[1] * one + a[0] * h - c[1] * one - c[0] * first - second) + p[1] * one + p[0] * first,
            own.mu_pa * (a[2] * one + a[1] * h - c[2] * one - c[1] * first - c[0] * second) + p[2] * one +
                p[1] * first + p[0] * second};
}

/// grad u of an element.
Matrix3d gradient(const ElementMesh& mesh, std::size_t t, const TetGeometry& geometry, const Eigen::Matrix3Xd& u) {
    Eigen::Matrix<double, 3, 4> corner;
    for (std::size_t c = 0; c < 4; ++c) corner.col(static_cast<Eigen::Index>(c)) = u.col(mesh.corner[t][c]);
    return corner * geometry.gradient_per_m.transpose();
}

}  // namespace

NeoHooke::NeoHooke(const ElementMesh& mesh) : mesh_(mesh) {
    if (mesh.element == Element::kAverageNodalPressure) cells_.emplace(mesh);
}

std::vector<Orders> NeoHooke::nodal_pressures(const Eigen::Matrix3Xd& u) const {
    std::vector<Orders> change;
    std::vector<double> volume_m3;
    for (std::size_t t = 0; t < mesh_.corner.size(); ++t) {
        const TetGeometry geometry = tet_geometry(corners_of(mesh_, t));
        change.push_back(volume_change(gradient(mesh_, t, geometry, u)));
        volume_m3.push_back(geometry.volume_m3);
    }
    std::vector<Orders> pressure_pa(change.size(), Orders{});
    for (std::size_t cell = 0; cell < cells_->size(); ++cell) {
        const Lame& material = cells_->material(cell);
        double volume = 0.0;
        Orders theta{};
        for (std::int32_t t : cells_->tets(cell)) {
            const auto e = static_cast<std::size_t>(t);
            volume += volume_m3[e];
            for (std::size_t k = 0; k < 3; ++k) theta[k] += volume_m3[e] * change[e][k];
        }
        const double per_corner = 0.25 * (material.lambda_pa - own_lambda_pa(mesh_.element, material)) / volume;
        for (std::int32_t t : cells_->tets(cell))
            for (std::size_t k = 0; k < 3; ++k) pressure_pa[static_cast<std::size_t>(t)][k] += per_corner * theta[k];
    }
    return pressure_pa;
}

ForceOrders NeoHooke::force_orders(const Eigen::Matrix3Xd& u) const {
    ForceOrders orders;
    for (auto& force : orders.force_n) force = Eigen::Matrix3Xd::Zero(3, u.cols());
    const std::vector<Orders> of_nodes = cells_ ? nodal_pressures(u) : std::vector<Orders>();
    for (std::size_t t = 0; t < mesh_.corner.size(); ++t) {
        const TetGeometry geometry = tet_geometry(corners_of(mesh_, t));
        const Lame own{own_lambda_pa(mesh_.element, mesh_.material[t]), mesh_.material[t].mu_pa};
        const auto p = stress(gradient(mesh_, t, geometry, u), own, cells_ ? of_nodes[t] : Orders{});
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Matrix<double, 3, 4> force = geometry.volume_m3 * p[k] * geometry.gradient_per_m;
            for (std::size_t c = 0; c < 4; ++c)
                orders.force_n[k].col(mesh_.corner[t][c]) += force.col(static_cast<Eigen::Index>(c));
        }
    }
    return orders;
}

}  // namespace haptable
