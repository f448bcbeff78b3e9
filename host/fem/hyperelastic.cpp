// SPDX-License-Identifier: GPL-2.0-or-later
// P = dW/dF = mu w'(x) (J^-2/3 F - 1/3 J^-5/3 tr(F^T F) cof F) + (kappa (J - 1) + p) cof F
#include "host/fem/hyperelastic.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;

Matrix3d deformation(const Matrix3Xd& moves, const ElementPoint& point) {
    return Matrix3d::Identity() + gradient_of(moves, point);
}

}  // namespace

Hyperelastic::Hyperelastic(const ElementMesh& mesh, const Stiffening& stiffening)
    : mesh_(mesh), stiffening_(stiffening) {
    for (std::size_t t = 0; t < mesh.corner.size(); ++t) {
        nodes_.push_back(nodes_of(mesh, t));
        points_.push_back(points_of(mesh, t));
    }
    if (mesh.element == Element::kLinear) return;
    const NodalCells cells(mesh);
    cell_count_ = cells.size();
    cells_.resize(mesh.corner.size());
    cell_volume_m3_.assign(cell_count_, 0.0);
    for (std::size_t cell = 0; cell < cell_count_; ++cell) {
        const Lame& material = cells.material(cell);
        left_pa_.push_back(material.lambda_pa - own_lambda_pa(mesh.element, material));
        for (std::int32_t tet : cells.tets(cell)) {
            const auto t = static_cast<std::size_t>(tet);
            const auto& all = mesh.corner[t];
            const auto c = static_cast<std::size_t>(std::find(all.begin(), all.end(), cells.node(cell)) - all.begin());
            cells_[t][c] = static_cast<std::int32_t>(cell);
            for (const ElementPoint& point : points_[t])
                cell_volume_m3_[cell] += point.volume_m3 * point.of_corner[static_cast<Eigen::Index>(c)];
        }
    }
}

double Hyperelastic::nodal_pressures(const Matrix3Xd& u, Eigen::VectorXd& pressure_pa) const {
    pressure_pa = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(cell_count_));
    for (std::size_t t = 0; t < nodes_.size(); ++t) {
        const Matrix3Xd moves = moves_of(nodes_[t], u);
        for (const ElementPoint& point : points_[t]) {
            const double change = point.volume_m3 * (deformation(moves, point).determinant() - 1.0);
            for (std::size_t c = 0; c < 4; ++c)
                pressure_pa[cells_[t][c]] += change * point.of_corner[static_cast<Eigen::Index>(c)];
        }
    }
    double stored_j = 0.0;
    for (std::size_t cell = 0; cell < cell_count_; ++cell) {
        double& value = pressure_pa[static_cast<Eigen::Index>(cell)];  // V_a theta_a first
        stored_j += 0.5 * left_pa_[cell] * value * value / cell_volume_m3_[cell];
        value *= left_pa_[cell] / cell_volume_m3_[cell];
    }
    return stored_j;
}

double Hyperelastic::energy(const Matrix3Xd& u, Matrix3Xd& force_n) const {
    Eigen::VectorXd of_cells;
    double sum_j = cell_count_ > 0 ? nodal_pressures(u, of_cells) : 0.0;
    force_n = Matrix3Xd::Zero(3, u.cols());
    for (std::size_t t = 0; t < nodes_.size(); ++t) {
        const double own_pa = own_lambda_pa(mesh_.element, mesh_.material[t]), mu_pa = mesh_.material[t].mu_pa;
        const double kappa_pa = own_pa + 2.0 / 3.0 * mu_pa;
        const Matrix3Xd moves = moves_of(nodes_[t], u);
        for (const ElementPoint& point : points_[t]) {
            const Matrix3d f = deformation(moves, point), cof = cofactor(f);
            const double j = f.col(0).dot(cof.col(0)), square = f.squaredNorm();
            if (!(j > 0.0)) return std::numeric_limits<double>::infinity();
            const double by = 1.0 / std::cbrt(j * j), x = by * square - 3.0;
            double pressure_pa = kappa_pa * (j - 1.0);
            for (std::size_t c = 0; c < 4 && cell_count_ > 0; ++c)
                pressure_pa += point.of_corner[static_cast<Eigen::Index>(c)] * of_cells[cells_[t][c]];
            sum_j += point.volume_m3 * (0.5 * mu_pa * stiffening_.w(x) + 0.5 * kappa_pa * (j - 1.0) * (j - 1.0));
            const Matrix3d p = mu_pa * stiffening_.slope(x) * by * (f - square / (3.0 * j) * cof) + pressure_pa * cof;
            const Matrix3Xd force = point.volume_m3 * p * point.gradient_per_m;
            for (std::size_t b = 0; b < nodes_[t].size(); ++b)
                force_n.col(nodes_[t][b]) += force.col(static_cast<Eigen::Index>(b));
        }
    }
    return sum_j;
}

}  // namespace haptable
