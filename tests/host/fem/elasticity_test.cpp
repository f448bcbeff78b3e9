// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/elasticity.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "host/fem/stiffness.hpp"
#include "host/mesh/cube.hpp"
#include "tests/dense.hpp"
#include "tests/host/fem/jittered_cube.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Matrix = Eigen::MatrixXd;

Corners corners(const TetMesh& mesh, const Tet& tet) {
    Corners corner_m;
    for (std::size_t c = 0; c < 4; ++c) corner_m[c] = mesh.position_m[std::size_t(tet[c])];
    return corner_m;
}

/// The textbook's way, for comparison: V B^T D B with engineering shear strains, shape functions from the inverse of
/// the matrix of corner coordinates (Zienkiewicz and Taylor, The Finite Element Method, chapter on tetrahedra).
Matrix textbook_stiffness(const Corners& corner, double young, double poisson) {
    Eigen::Matrix4d a;
    for (int c = 0; c < 4; ++c) a.row(c) << 1.0, corner[std::size_t(c)].transpose();
    const Eigen::Matrix4d shape = a.inverse();  // column c: coefficients 1, x, y, z of N_c
    Matrix b = Matrix::Zero(6, 12);
    for (int c = 0; c < 4; ++c) {
        const double x = shape(1, c), y = shape(2, c), z = shape(3, c);
        b.block<6, 3>(0, 3 * c) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
    }
    Matrix compliance = Matrix::Zero(6, 6);  // D from its inverse: strains from stresses, as Hooke's law is taught
    compliance.topLeftCorner<3, 3>().setConstant(-poisson / young);
    compliance.diagonal() << Eigen::Vector3d::Constant(1.0 / young),
        Eigen::Vector3d::Constant(2.0 * (1.0 + poisson) / young);
    return std::abs(a.determinant()) / 6.0 * transposed_product(b, dense::product(dense::inverse(compliance), b));
}

/// Of the two matrices that the textbook inverts: that of the corners, whose columns may have any unit,
double condition_of_corners(const Corners& corner) {
    Eigen::Matrix4d a;
    for (int c = 0; c < 4; ++c) a.row(c) << 1.0, corner[std::size_t(c)].transpose();
    a.colwise().normalize();
    const Eigen::VectorXd squared = dense::eigenvalues(a.transpose() * a);  // of the singular values
    return std::sqrt(squared[3] / squared[0]);
}
/// and that of the strains: the resistance to a change of volume against that to one of shape.
double condition_of_hooke(double poisson) {
    const double ratio = (1.0 + poisson) / (1.0 - 2.0 * poisson);
    return std::max(2.0 * ratio, 1.0 / ratio);
}

TEST(Elasticity, ElementAgreesWithTheTextbook) {
    for (const auto& [side, young] : {std::pair{0.03, 1e4}, {0.03e-3, 1e4}, {0.03e3, 1e4}, {0.03, 1e7}}) {
        const TetMesh mesh = test::jittered_cube(4, side);
        for (double poisson : {-0.5, 0.0, 0.3, 0.49, 0.4999})
            for (const Tet& tet : mesh.tet) {
                const Matrix expected = textbook_stiffness(corners(mesh, tet), young, poisson);
                const Matrix k = element_stiffness(tet_geometry(corners(mesh, tet)), Lame::from_young(young, poisson));
                const double condition = condition_of_corners(corners(mesh, tet)) * condition_of_hooke(poisson);
                ASSERT_WITHIN((k - expected).norm() / expected.norm(), .count = 32, .condition = condition)
                    << "nu = " << poisson << ", " << side << " m, " << young << " Pa";
            }
    }
}

}  // namespace
}  // namespace haptable
