// SPDX-License-Identifier: GPL-2.0-or-later
// K_ab = sum_q V_q (lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) I),   g_a = grad N_a
//
// The 3x3 blocks of a tetrahedron's stiffness. Of the linear one the strain is constant, so the integral of B_a^T D B_b
// is its volume V times one product. Written with the gradients it needs neither B nor D.
#include "host/fem/elasticity.hpp"

#include <Eigen/Geometry>

namespace haptable {

Lame Lame::from_young(double young_pa, double poisson) {
    return {young_pa * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young_pa / (2.0 * (1.0 + poisson))};
}

namespace {

/// lambda, mu: times the volume.
Eigen::Matrix3d block_of(const Eigen::Matrix3d& outer, double lambda, double mu) {
    return lambda * outer + (mu * outer.transpose() + mu * outer.trace() * Eigen::Matrix3d::Identity());
}

}  // namespace

TetGeometry tet_geometry(const Corners& corner_m) {
    // Differences first: a body far from the origin keeps its digits.
    const Eigen::Vector3d e1 = corner_m[1] - corner_m[0];
    const Eigen::Vector3d e2 = corner_m[2] - corner_m[0];
    const Eigen::Vector3d e3 = corner_m[3] - corner_m[0];
    const double det = e1.dot(e2.cross(e3));
    TetGeometry geometry;
    geometry.volume_m3 = det / 6.0;
    geometry.gradient_per_m.col(1) = e2.cross(e3) / det;
    geometry.gradient_per_m.col(2) = e3.cross(e1) / det;
    geometry.gradient_per_m.col(3) = e1.cross(e2) / det;
    geometry.gradient_per_m.col(0) = -geometry.gradient_per_m.rightCols<3>().rowwise().sum();
    return geometry;
}

Eigen::Matrix<double, 12, 12> element_stiffness(const TetGeometry& geometry, const Lame& material) {
    const double lambda = geometry.volume_m3 * material.lambda_pa;
    const double mu = geometry.volume_m3 * material.mu_pa;
    Eigen::Matrix<double, 12, 12> k;
    for (Eigen::Index a = 0; a < 4; ++a)
        for (Eigen::Index b = 0; b < 4; ++b) {
            const Eigen::Matrix3d outer = geometry.gradient_per_m.col(a) * geometry.gradient_per_m.col(b).transpose();
            k.block<3, 3>(3 * a, 3 * b) = block_of(outer, lambda, mu);
        }
    return k;
}

Eigen::Matrix<double, 30, 30> element_stiffness(const TenNodes& node_m, const Lame& material) {
    Eigen::Matrix<double, 30, 30> k = Eigen::Matrix<double, 30, 30>::Zero();
    for (const Eigen::Vector4d& t : tet_points()) {
        const auto [det, gradient] = tet_point(node_m, t);
        const double lambda = det / 24.0 * material.lambda_pa, mu = det / 24.0 * material.mu_pa;
        for (Eigen::Index a = 0; a < 10; ++a)
            for (Eigen::Index b = 0; b <= a; ++b)
                k.block<3, 3>(3 * a, 3 * b) += block_of(gradient.col(a) * gradient.col(b).transpose(), lambda, mu);
    }
    k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
    return k;
}

}  // namespace haptable
