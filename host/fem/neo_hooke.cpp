// SPDX-License-Identifier: GPL-2.0-or-later
// P(I + t H) = mu (J^-2/3 F - J^-5/3 tr(F^T F)/3 cof F) + (kappa (J - 1) + p) cof F
// J = 1 + j_1 t + j_2 t^2 + j_3 t^3,   cof F = I + (tr H I - H^T) t + cof H t^2
#include "host/fem/neo_hooke.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "host/fem/element_points.hpp"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Orders = std::array<double, 3>;  // of t, t^2, t^3

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

}  // namespace

NeoHooke::NeoHooke(const ElementMesh& mesh) : mesh_(mesh) {
    if (mesh.element != Element::kLinear) cells_.emplace(mesh);
}

std::vector<NeoHooke::AtCorners> NeoHooke::nodal_pressures(const Eigen::Matrix3Xd& u) const {
    const std::size_t tets = mesh_.corner.size();
    std::vector<AtCorners> change(tets, AtCorners::Zero()), pressure_pa = change;  // V_a (J - 1) of each corner first
    std::vector<Eigen::Vector4d> volume_m3(tets, Eigen::Vector4d::Zero());
    for (std::size_t t = 0; t < tets; ++t) {
        const Eigen::Matrix3Xd moves = moves_of(nodes_of(mesh_, t), u);
        for (const ElementPoint& point : points_of(mesh_, t)) {
            const Orders j = volume_change(gradient_of(moves, point));
            volume_m3[t] += point.volume_m3 * point.of_corner;
            change[t] += point.volume_m3 * point.of_corner * Eigen::Map<const Eigen::RowVector3d>(j.data());
        }
    }
    for (std::size_t cell = 0; cell < cells_->size(); ++cell) {
        const Lame& material = cells_->material(cell);
        double volume = 0.0;
        Eigen::RowVector3d theta = Eigen::RowVector3d::Zero();
        const auto corner = [&](std::size_t t) {
            const auto& all = mesh_.corner[t];
            return std::find(all.begin(), all.end(), cells_->node(cell)) - all.begin();
        };
        for (std::int32_t tet : cells_->tets(cell)) {
            const auto t = static_cast<std::size_t>(tet);
            volume += volume_m3[t][corner(t)];
            theta += change[t].row(corner(t));
        }
        theta *= (material.lambda_pa - own_lambda_pa(mesh_.element, material)) / volume;
        for (std::int32_t tet : cells_->tets(cell)) {
            const auto t = static_cast<std::size_t>(tet);
            pressure_pa[t].row(corner(t)) = theta;
        }
    }
    return pressure_pa;
}

ForceOrders NeoHooke::force_orders(const Eigen::Matrix3Xd& u) const {
    ForceOrders orders;
    for (auto& force : orders.force_n) force = Eigen::Matrix3Xd::Zero(3, u.cols());
    const std::vector<AtCorners> of_nodes = cells_ ? nodal_pressures(u) : std::vector<AtCorners>();
    for (std::size_t t = 0; t < mesh_.corner.size(); ++t) {
        const Lame own{own_lambda_pa(mesh_.element, mesh_.material[t]), mesh_.material[t].mu_pa};
        const std::vector<std::int32_t> nodes = nodes_of(mesh_, t);
        const Eigen::Matrix3Xd moves = moves_of(nodes, u);
        for (const ElementPoint& point : points_of(mesh_, t)) {
            Orders pressure_pa{};
            if (cells_) Eigen::Map<Eigen::RowVector3d>(pressure_pa.data()) = point.of_corner.transpose() * of_nodes[t];
            const auto p = stress(gradient_of(moves, point), own, pressure_pa);
            for (std::size_t k = 0; k < 3; ++k) {
                const Eigen::Matrix3Xd force = point.volume_m3 * p[k] * point.gradient_per_m;
                for (std::size_t b = 0; b < nodes.size(); ++b)
                    orders.force_n[k].col(nodes[b]) += force.col(static_cast<Eigen::Index>(b));
            }
        }
    }
    return orders;
}

}  // namespace haptable
