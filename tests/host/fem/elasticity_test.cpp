// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/elasticity.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>
#include <random>

#include "host/mesh/cube.hpp"

namespace haptable {

namespace {

using Matrix = Eigen::MatrixXd;

/// K of all nodes, nothing held.
Eigen::SparseMatrix<double> free_stiffness(const TetMesh& mesh, const Lame& lame) {
    std::vector<std::int32_t> all(mesh.position_m.size());
    std::iota(all.begin(), all.end(), 0);
    return assemble_stiffness(mesh.position_m, mesh.tet, std::vector<Lame>(mesh.tet.size(), lame), all,
                              static_cast<std::int32_t>(all.size()));
}

Corners corners(const TetMesh& mesh, const Tet& tet) {
    Corners corner_m;
    for (std::size_t c = 0; c < 4; ++c) corner_m[c] = mesh.position_m[static_cast<std::size_t>(tet[c])];
    return corner_m;
}

bool inside(const Eigen::Vector3d& p, double side) { return p.minCoeff() > 0.0 && p.maxCoeff() < side; }

/// A cube whose inner nodes are moved by up to 15 % of an edge.
TetMesh jittered_cube(int n, double side) {
    TetMesh mesh = make_cube(n, side);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> shift(-0.15 * side / (n - 1), 0.15 * side / (n - 1));
    for (Eigen::Vector3d& p : mesh.position_m)
        if (inside(p, side)) p += Eigen::Vector3d(shift(random), shift(random), shift(random));
    return mesh;
}

/// The textbook's way, for comparison: V B^T D B with engineering shear strains, shape functions from the inverse of
/// the matrix of corner coordinates (Zienkiewicz and Taylor, The Finite Element Method, chapter on tetrahedra).
Matrix textbook_stiffness(const Corners& corner, double young, double poisson) {
    Eigen::Matrix4d a;
    for (int c = 0; c < 4; ++c) a.row(c) << 1.0, corner[static_cast<std::size_t>(c)].transpose();
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
    return std::abs(a.determinant()) / 6.0 * b.transpose() * compliance.inverse() * b;
}

TEST(Elasticity, ElementAgreesWithTheTextbook) {
    const TetMesh mesh = jittered_cube(4, 0.03);
    for (double poisson : {-0.5, 0.0, 0.3, 0.49, 0.4999})
        for (const Tet& tet : mesh.tet) {
            const Matrix expected = textbook_stiffness(corners(mesh, tet), 1e4, poisson);
            const Matrix k = element_stiffness(tet_geometry(corners(mesh, tet)), Lame::from_young(1e4, poisson));
            ASSERT_LT((k - expected).norm() / expected.norm(), 1e-11) << "nu = " << poisson;
        }
}

TEST(Elasticity, StiffnessIsSymmetricToTheLastBit) {
    const Eigen::SparseMatrix<double> k = free_stiffness(jittered_cube(4, 0.03), Lame::from_young(1e4, 0.49));
    EXPECT_EQ(Matrix(k), Matrix(k.transpose()));
}

TEST(Elasticity, RigidMotionsAreTheNullSpaceOfTheFreeStiffness) {
    for (double side : {0.03e-3, 0.03, 0.03e3}) {
        const TetMesh mesh = jittered_cube(4, side);
        const Matrix k = free_stiffness(mesh, Lame::from_young(1e4, 0.49));
        Matrix rigid(k.rows(), 6);
        for (Eigen::Index i = 0; i < k.rows() / 3; ++i) {
            const Eigen::Vector3d x = mesh.position_m[static_cast<std::size_t>(i)] / side;
            rigid.block<3, 3>(3 * i, 0).setIdentity();
            for (int axis = 0; axis < 3; ++axis)
                rigid.block<3, 1>(3 * i, 3 + axis) = Eigen::Vector3d::Unit(axis).cross(x);
        }
        const Eigen::VectorXd eigenvalue = Eigen::SelfAdjointEigenSolver<Matrix>(k).eigenvalues();
        const double largest = eigenvalue[k.rows() - 1];
        EXPECT_LT((k * rigid).colwise().norm().maxCoeff() / (largest * rigid.colwise().norm().minCoeff()), 1e-14);
        EXPECT_LT(std::abs(eigenvalue[5]) / largest, 1e-14) << "six motions cost nothing";
        EXPECT_GT(eigenvalue[6] / largest, 1e-5) << "and no seventh";
    }
}

/// Displaces the boundary by u = A x and solves for the inner nodes, densely.
Eigen::VectorXd follow_boundary(const TetMesh& mesh, const Matrix& k, const Eigen::Matrix3d& a, double side) {
    std::vector<Eigen::Index> inner;
    Eigen::VectorXd u(k.rows());
    for (std::size_t i = 0; i < mesh.position_m.size(); ++i) {
        const bool is_inner = inside(mesh.position_m[i], side);
        const auto row = 3 * static_cast<Eigen::Index>(i);
        u.segment<3>(row) = is_inner ? Eigen::Vector3d::Zero() : Eigen::Vector3d(a * mesh.position_m[i]);
        for (Eigen::Index c = 0; is_inner && c < 3; ++c) inner.push_back(row + c);
    }
    const Eigen::VectorXd load = -(k * u)(inner);
    u(inner) = Eigen::FullPivLU<Matrix>(k(inner, inner)).solve(load);
    return u;
}

TEST(Elasticity, PatchTestOfConstantStrain) {
    Eigen::Matrix3d a;
    a << 0.01, 0.02, -0.03, 0.004, -0.05, 0.06, -0.007, 0.08, 0.009;
    for (double poisson : {0.0, 0.3, 0.49})
        for (double side : {0.03e-3, 0.03, 0.03e3}) {
            const TetMesh mesh = jittered_cube(5, side);
            const Lame lame = Lame::from_young(1e4, poisson);
            const Eigen::VectorXd u = follow_boundary(mesh, free_stiffness(mesh, lame), a, side);
            for (std::size_t i = 0; i < mesh.position_m.size(); ++i)
                ASSERT_LT((u.segment<3>(3 * static_cast<Eigen::Index>(i)) - a * mesh.position_m[i]).norm() / side,
                          1e-12);
            const Eigen::Matrix3d strain = 0.5 * (a + a.transpose());
            const Eigen::Matrix3d stress =
                lame.lambda_pa * strain.trace() * Eigen::Matrix3d::Identity() + 2.0 * lame.mu_pa * strain;
            for (const Tet& tet : mesh.tet) {
                Eigen::Matrix<double, 3, 4> moved;
                for (int c = 0; c < 4; ++c) moved.col(c) = u.segment<3>(3 * tet[static_cast<std::size_t>(c)]);
                const Eigen::Matrix3d gradient = moved * tet_geometry(corners(mesh, tet)).gradient_per_m.transpose();
                const Eigen::Matrix3d e = 0.5 * (gradient + gradient.transpose());
                const Eigen::Matrix3d s =
                    lame.lambda_pa * e.trace() * Eigen::Matrix3d::Identity() + 2.0 * lame.mu_pa * e;
                ASSERT_LT((s - stress).norm() / stress.norm(), 1e-10);
            }
        }
}

TEST(Elasticity, StretchingStoresTheEnergyOfHookesLaw) {
    const TetMesh mesh = jittered_cube(4, 0.03);
    const Lame lame = Lame::from_young(1e4, 0.3);
    const Matrix k = free_stiffness(mesh, lame);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(k.rows());
    for (std::size_t i = 0; i < mesh.position_m.size(); ++i)
        u[3 * static_cast<Eigen::Index>(i)] = 0.01 * mesh.position_m[i].x();
    const double energy = 0.5 * (lame.lambda_pa + 2.0 * lame.mu_pa) * 0.01 * 0.01 * 2.7e-5;
    EXPECT_NEAR(0.5 * u.dot(k * u) / energy, 1.0, 1e-12);
}

TEST(Elasticity, StiffnessScalesWithSizeAndYoungsModulus) {
    const Matrix k = free_stiffness(make_cube(3, 1.0), Lame::from_young(1e4, 0.3));
    for (double scale : {1e-3, 1e3}) {
        const Matrix scaled = free_stiffness(make_cube(3, scale), Lame::from_young(1e4, 0.3));
        EXPECT_LT((scaled / scale - k).norm() / k.norm(), 1e-13);
    }
    const Matrix stiffer = free_stiffness(make_cube(3, 1.0), Lame::from_young(1e7, 0.3));
    EXPECT_LT((stiffer / 1e3 - k).norm() / k.norm(), 1e-13);
}

TEST(Elasticity, TheReducedStiffnessIsAPartOfTheFreeOne) {
    const TetMesh mesh = jittered_cube(4, 0.03);
    const Lame lame = Lame::from_young(1e4, 0.3);
    std::vector<std::int32_t> unknown;
    std::vector<Eigen::Index> rows;
    std::int32_t count = 0;
    for (std::size_t i = 0; i < mesh.position_m.size(); ++i) {
        unknown.push_back(mesh.position_m[i].z() > 0.0 ? count++ : -1);
        for (Eigen::Index c = 0; unknown.back() >= 0 && c < 3; ++c)
            rows.push_back(3 * static_cast<Eigen::Index>(i) + c);
    }
    const Matrix reduced =
        assemble_stiffness(mesh.position_m, mesh.tet, std::vector<Lame>(mesh.tet.size(), lame), unknown, count);
    EXPECT_EQ(reduced, Matrix(free_stiffness(mesh, lame))(rows, rows));
}

TEST(Elasticity, EveryElementHasItsOwnMaterial) {
    const TetMesh mesh = make_cube(2, 1.0);
    std::vector<std::int32_t> all(8);
    std::iota(all.begin(), all.end(), 0);
    std::vector<Lame> lame(5);
    Matrix sum = Matrix::Zero(24, 24);
    for (std::size_t t = 0; t < 5; ++t) {
        std::vector<Lame> only(5);
        only[t] = lame[t] = Lame::from_young(1e3 * static_cast<double>(t + 1), 0.1 * static_cast<double>(t));
        sum += Matrix(assemble_stiffness(mesh.position_m, mesh.tet, only, all, 8));
    }
    const Matrix k = assemble_stiffness(mesh.position_m, mesh.tet, lame, all, 8);
    EXPECT_LT((k - sum).norm() / k.norm(), 1e-15);
}

}  // namespace

}  // namespace haptable
