// SPDX-License-Identifier: GPL-2.0-or-later
// K_ab = sum_q V_q B_a^T D B_b
#include "host/fem/hooke.hpp"

#include <Eigen/Cholesky>

namespace haptable {

namespace {

/// B_a of a node: strain = sum_a B_a u_a. gradient: of its shape function.
Eigen::Matrix<double, 6, 3> strain_matrix(const Eigen::Vector3d& gradient) {
    const double x = gradient.x(), y = gradient.y(), z = gradient.z();
    Eigen::Matrix<double, 6, 3> b;
    b << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, z, 0, x, 0, z, y;
    return b;
}

/// Adds volume B^T D B to the lower triangle.
template <int nodes>
void add_lower(const Eigen::Matrix<double, 3, nodes>& gradient, double volume, const Hooke& law,
               Eigen::Matrix<double, 3 * nodes, 3 * nodes>& k) {
    Eigen::Matrix<double, 6, 3 * nodes> b;
    for (Eigen::Index a = 0; a < nodes; ++a) b.template middleCols<3>(3 * a) = strain_matrix(gradient.col(a));
    const Eigen::Matrix<double, 6, 3 * nodes> db = volume * law * b;
    k.template triangularView<Eigen::Lower>() += b.transpose() * db;
}

}  // namespace

Hooke orthotropic_hooke(const std::array<double, 3>& e, const std::array<double, 3>& nu,
                        const std::array<double, 3>& g) {
    Hooke compliance = Hooke::Zero();
    compliance.diagonal() << 1.0 / e[0], 1.0 / e[1], 1.0 / e[2], 1.0 / g[0], 1.0 / g[1], 1.0 / g[2];
    compliance(0, 1) = compliance(1, 0) = -nu[0] / e[0];
    compliance(0, 2) = compliance(2, 0) = -nu[1] / e[0];
    compliance(1, 2) = compliance(2, 1) = -nu[2] / e[1];
    Hooke law = compliance.llt().solve(Hooke::Identity());
    law.triangularView<Eigen::StrictlyUpper>() = law.transpose();
    return law;
}

Hooke isotropic_hooke(const Lame& material) {
    Hooke law = Hooke::Zero();
    law.topLeftCorner<3, 3>().setConstant(material.lambda_pa);
    law.diagonal().head<3>().array() += 2.0 * material.mu_pa;
    law.diagonal().tail<3>().setConstant(material.mu_pa);
    return law;
}

Hooke turned(const Hooke& own, const Eigen::Matrix3d& axes) {
    constexpr int kRow[] = {0, 1, 2, 0, 0, 1}, kColumn[] = {0, 1, 2, 1, 2, 2};
    Eigen::Matrix<double, 6, 6> turn;  // own strain = turn strain
    for (Eigen::Index k = 0; k < 6; ++k) {
        Gradient unit = Gradient::Zero();
        unit(kRow[k], kColumn[k]) = 1.0;
        turn.col(k) = strain_of(axes.transpose() * unit * axes);
    }
    Hooke law = turn.transpose() * own * turn;
    law.triangularView<Eigen::StrictlyUpper>() = law.transpose();
    return law;
}

Voigt strain_of(const Gradient& g) {
    Voigt strain;
    strain << g(0, 0), g(1, 1), g(2, 2), g(0, 1) + g(1, 0), g(0, 2) + g(2, 0), g(1, 2) + g(2, 1);
    return strain;
}

Eigen::Matrix3d stress_of(const Voigt& s) {
    Eigen::Matrix3d stress;
    stress << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
    return stress;
}

Eigen::Matrix<double, 12, 12> element_stiffness(const TetGeometry& geometry, const Hooke& law) {
    Eigen::Matrix<double, 12, 12> k = Eigen::Matrix<double, 12, 12>::Zero();
    add_lower<4>(geometry.gradient_per_m, geometry.volume_m3, law, k);
    k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
    return k;
}

Eigen::Matrix<double, 30, 30> element_stiffness(const TenNodes& node_m, const Hooke& law) {
    Eigen::Matrix<double, 30, 30> k = Eigen::Matrix<double, 30, 30>::Zero();
    for (const Eigen::Vector4d& t : tet_points()) {
        const auto [det, gradient] = tet_point(node_m, t);
        add_lower<10>(gradient, det / 24.0, law, k);
    }
    k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
    return k;
}

}  // namespace haptable
