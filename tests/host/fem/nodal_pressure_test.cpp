// SPDX-License-Identifier: GPL-2.0-or-later
// Tetrahedra that average their change of volume at the nodes, as a discretisation.
#include "host/fem/nodal_pressure.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include "host/inverse/factor.hpp"
#include "host/mesh/cube.hpp"
#include "tests/conditioning.hpp"
#include "tests/dense.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;
using Matrix = Eigen::MatrixXd;
using Materials = std::vector<Lame>;
constexpr double kPi = std::numbers::pi;

bool is_inside(const Vector3d& p, double side) { return p.minCoeff() > 0.0 && p.maxCoeff() < side; }

/// A cube whose inner nodes are moved by up to 15 % of an edge.
TetMesh jittered_cube(int n, double side) {
    TetMesh mesh = make_cube(n, side);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> shift(-0.15 * side / (n - 1), 0.15 * side / (n - 1));
    for (Vector3d& p : mesh.position_m)
        if (is_inside(p, side)) p += Vector3d(shift(random), shift(random), shift(random));
    return mesh;
}

ElementMesh element_mesh(const TetMesh& mesh, const Materials& material, Element element) {
    return {element, mesh.position_m, mesh.tet, material};
}

/// K and its unknowns: all nodes, or those inside the cube.
struct Problem {
    std::vector<std::int32_t> unknown, node;
    StiffnessParts parts;

    Eigen::SparseMatrix<double> k() const {
        const Eigen::SparseMatrix<double> g = parts.g;
        return parts.a + Eigen::SparseMatrix<double>(g.transpose() * g);
    }
};
Problem assemble_where(const TetMesh& mesh, const Materials& material, Element element,
                       const std::function<bool(const Vector3d&)>& is_free) {
    Problem problem;
    for (std::size_t i = 0; i < mesh.position_m.size(); ++i) {
        const bool free = is_free(mesh.position_m[i]);
        problem.unknown.push_back(free ? static_cast<std::int32_t>(problem.node.size()) : -1);
        if (free) problem.node.push_back(static_cast<std::int32_t>(i));
    }
    problem.parts = assemble_stiffness(element_mesh(mesh, material, element), problem.unknown,
                                       static_cast<std::int32_t>(problem.node.size()));
    return problem;
}
Matrix free_stiffness(const TetMesh& mesh, const Lame& lame, Element element) {
    const auto all = [](const Vector3d&) { return true; };
    return assemble_where(mesh, Materials(mesh.tet.size(), lame), element, all).k();
}

Matrix rigid_motions(const TetMesh& mesh, double side) {
    Matrix rigid(3 * static_cast<Eigen::Index>(mesh.position_m.size()), 6);
    for (Eigen::Index i = 0; i < rigid.rows() / 3; ++i) {
        rigid.block<3, 3>(3 * i, 0).setIdentity();
        for (int axis = 0; axis < 3; ++axis)
            rigid.block<3, 1>(3 * i, 3 + axis) =
                Vector3d::Unit(axis).cross(mesh.position_m[static_cast<std::size_t>(i)] / side);
    }
    return rigid;
}

TEST(NodalPressure, RigidMotionsAreTheNullSpaceOfTheFreeStiffness) {
    for (double poisson : {-0.5, 0.3, 0.4999})
        for (double side : {0.03e-3, 0.03, 0.03e3}) {
            const TetMesh mesh = jittered_cube(4, side);
            const Lame lame = Lame::from_young(1e4, poisson);
            const Matrix k = free_stiffness(mesh, lame, Element::kAverageNodalPressure);
            EXPECT_EQ(k, Matrix(k.transpose()));
            const Matrix rigid = rigid_motions(mesh, side);
            const Eigen::VectorXd eigenvalue = dense::eigenvalues(k);
            const double largest = eigenvalue[k.rows() - 1];
            const double count = 4.0 * std::sqrt(3.0 * 64.0);  // as of linear tetrahedra: entries of a row
            EXPECT_WITHIN(
                dense::product(k, rigid).colwise().norm().maxCoeff() / (largest * rigid.colwise().norm().minCoeff()),
                .count = count);
            EXPECT_WITHIN(std::abs(eigenvalue[5]) / largest, .count = count);
            // Averaging leaves no motion without energy: the shear part resists whatever strains an element.
            EXPECT_GT(eigenvalue[6] / (lame.mu_pa * side), 1e-3);
        }
}

TEST(NodalPressure, NoMotionStoresMoreThanInLinearTetrahedra) {
    const TetMesh mesh = jittered_cube(4, 0.03);
    for (double poisson : {-0.5, 0.0, 0.3, 0.4999}) {
        const Lame lame = Lame::from_young(1e4, poisson);
        const Matrix linear = free_stiffness(mesh, lame, Element::kLinear);
        const Matrix averaged = free_stiffness(mesh, lame, Element::kAverageNodalPressure);
        const Eigen::VectorXd difference = dense::eigenvalues(linear - averaged);
        EXPECT_WITHIN(-difference[0] / linear.norm(), .count = 64.0) << "nu = " << poisson;
        // Up to 1/6 lambda is at most mu / 2, and there is nothing to average.
        EXPECT_EQ(linear == averaged, poisson < 1.0 / 6.0);
    }
}

/// Displaces the boundary by u = A x and solves for the inner nodes.
double patch_test_error(const TetMesh& mesh, const Lame& lame, const Eigen::Matrix3d& a, double side) {
    const Matrix k = free_stiffness(mesh, lame, Element::kAverageNodalPressure);
    std::vector<Eigen::Index> inner;
    Eigen::VectorXd u(k.rows());
    for (std::size_t i = 0; i < mesh.position_m.size(); ++i) {
        const auto row = 3 * static_cast<Eigen::Index>(i);
        u.segment<3>(row) = a * mesh.position_m[i];
        if (is_inside(mesh.position_m[i], side)) inner.insert(inner.end(), {row, row + 1, row + 2});
    }
    const Eigen::VectorXd exact = u;
    u(inner).setZero();
    const Eigen::VectorXd load = -(k * u)(inner);
    u(inner) = dense::solve(k(inner, inner), load);
    return (u - exact).cwiseAbs().maxCoeff() / side;
}

TEST(NodalPressure, PatchTestOfConstantStrain) {
    Eigen::Matrix3d a;
    a << 0.01, 0.02, -0.03, 0.004, -0.05, 0.06, -0.007, 0.08, 0.009;
    for (double poisson : {0.3, 0.49, 0.4999})
        for (double side : {0.03e-3, 0.03, 0.03e3})
            EXPECT_LT(patch_test_error(jittered_cube(5, side), Lame::from_young(1e4, poisson), a, side), 1e-10)
                << "nu = " << poisson;
}

// u = curl (0, 0, S(x) S(y) S(z)) with S = sin^2(pi x): 0 on the boundary, without change of volume. It solves
// mu Laplace u - grad p + f = 0 with f = -mu Laplace u + grad p: of a nearly incompressible body for any p, and for p =
// 0 of every body.
double s(double x) { return std::sin(kPi * x) * std::sin(kPi * x); }
double s1(double x) { return kPi * std::sin(2 * kPi * x); }
double s2(double x) { return 2 * kPi * kPi * std::cos(2 * kPi * x); }
double s3(double x) { return -4 * kPi * kPi * kPi * std::sin(2 * kPi * x); }
Vector3d swirl(const Vector3d& x) { return {s(x[0]) * s1(x[1]) * s(x[2]), -s1(x[0]) * s(x[1]) * s(x[2]), 0.0}; }
Vector3d laplacian_of_swirl(const Vector3d& x) {
    return {s2(x[0]) * s1(x[1]) * s(x[2]) + s(x[0]) * s3(x[1]) * s(x[2]) + s(x[0]) * s1(x[1]) * s2(x[2]),
            -s3(x[0]) * s(x[1]) * s(x[2]) - s1(x[0]) * s2(x[1]) * s(x[2]) - s1(x[0]) * s(x[1]) * s2(x[2]), 0.0};
}
double pressure(const Vector3d& x) { return std::cos(kPi * x[0]) * std::cos(kPi * x[1]) * std::cos(kPi * x[2]); }
Vector3d gradient_of_pressure(const Vector3d& x) {
    Vector3d gradient;
    for (int c = 0; c < 3; ++c)
        gradient[c] = -kPi * std::sin(kPi * x[c]) * std::cos(kPi * x[(c + 1) % 3]) * std::cos(kPi * x[(c + 2) % 3]);
    return gradient;
}

std::vector<double> node_volumes(const TetMesh& mesh) {
    std::vector<double> volume(mesh.position_m.size());
    for (const Tet& tet : mesh.tet)
        for (std::int32_t i : tet) volume[static_cast<std::size_t>(i)] += six_volumes(mesh.position_m, tet) / 24.0;
    return volume;
}

/// Against the exact solution: of the displacements, as a share; of the elements' pressures, by mu.
struct Errors {
    double displacement = 0.0, pressure = 0.0;
};

/// The body force at a node times its volume. A body that is compressed by it would not move as a swirl.
Matrix swirl_load(const TetMesh& mesh, const Problem& problem, double mu, bool with_pressure) {
    const std::vector<double> volume = node_volumes(mesh);
    Matrix load(3 * static_cast<Eigen::Index>(problem.node.size()), 1);
    for (std::size_t k = 0; k < problem.node.size(); ++k) {
        const auto i = static_cast<std::size_t>(problem.node[k]);
        const Vector3d& x = mesh.position_m[i];
        Vector3d force = -mu * laplacian_of_swirl(x);
        if (with_pressure) force += gradient_of_pressure(x);
        load.col(0).segment<3>(3 * static_cast<Eigen::Index>(k)) = volume[i] * force;
    }
    return load;
}

double displacement_error(const TetMesh& mesh, const Problem& problem, const Matrix& u) {
    double off = 0.0, size = 0.0;
    for (std::size_t k = 0; k < problem.node.size(); ++k) {
        const Vector3d exact = swirl(mesh.position_m[static_cast<std::size_t>(problem.node[k])]);
        off += (u.block<3, 1>(3 * static_cast<Eigen::Index>(k), 0) - exact).squaredNorm();
        size += exact.squaredNorm();
    }
    return std::sqrt(off / size);
}

/// Nodal pressures are -(lambda - lambda_e) theta with G u = sqrt((lambda - lambda_e) V) theta; an element feels the
/// mean of its four.
double pressure_error(const TetMesh& mesh, const Problem& problem, double lambda, const Matrix& u) {
    const std::vector<double> node_volume = node_volumes(mesh);
    const Eigen::VectorXd g = problem.parts.g * u.col(0);
    std::vector<double> off(node_volume.size());
    for (std::size_t row = 0; row < problem.parts.node.size(); ++row) {
        const auto i = static_cast<std::size_t>(problem.parts.node[row]);
        off[i] = -std::sqrt(lambda / node_volume[i]) * g[static_cast<Eigen::Index>(row)] - pressure(mesh.position_m[i]);
    }
    double sum = 0.0;
    for (const Tet& tet : mesh.tet) {
        double mean = 0.0;
        for (std::int32_t i : tet) mean += 0.25 * off[static_cast<std::size_t>(i)];
        sum += mean * mean * six_volumes(mesh.position_m, tet) / 6.0;  // of a cube of volume 1
    }
    return std::sqrt(sum);
}

Errors errors_of(int n, double poisson, Element element) {
    const TetMesh mesh = jittered_cube(n, 1.0);
    const Lame lame = Lame::from_young(2.0 * (1.0 + poisson), poisson);  // mu = 1
    const Problem problem = assemble_where(mesh, Materials(mesh.tet.size(), lame), element,
                                           [](const Vector3d& p) { return is_inside(p, 1.0 - 1e-9); });
    const bool with_pressure = poisson > 0.49;
    Matrix u;
    Factor(problem.k()).solve(swirl_load(mesh, problem, lame.mu_pa, with_pressure), u);
    return {displacement_error(mesh, problem, u),
            with_pressure ? pressure_error(mesh, problem, lame.lambda_pa - 0.5 * lame.mu_pa, u) : 0.0};
}

TEST(NodalPressure, DisplacementsConvergeByTheSquareOfTheEdgeAtAnyPoissonsRatio) {
    for (double poisson : {0.3, 0.4999}) {
        const Errors coarse = errors_of(9, poisson, Element::kAverageNodalPressure);
        const Errors fine = errors_of(17, poisson, Element::kAverageNodalPressure);
        EXPECT_NEAR(std::log2(coarse.displacement / fine.displacement), 2.0, 0.5) << "nu = " << poisson;
    }
    EXPECT_GT(errors_of(9, 0.4999, Element::kLinear).displacement, 0.9) << "linear ones hardly move";
}

// Nodal pressures are not stable in the sense of Babuska and Brezzi: from node to node they alternate. What counts is
// that this neither grows with lambda nor with refinement: then displacements, all that the tables hold, are sound.
TEST(NodalPressure, TheCheckerboardOfPressureIsBounded) {
    const Errors coarse = errors_of(9, 0.4999, Element::kAverageNodalPressure);
    const Errors fine = errors_of(17, 0.4999, Element::kAverageNodalPressure);
    const Errors stiffer = errors_of(9, 0.499999, Element::kAverageNodalPressure);
    EXPECT_LT(fine.pressure, coarse.pressure);
    EXPECT_LT(stiffer.pressure, 5.0 * coarse.pressure) << "lambda is a hundred times as much";
    EXPECT_LT(stiffer.displacement, 2.0 * coarse.displacement);
}

// A column that cannot widen: each layer is a spring of lambda + 2 mu.
TEST(NodalPressure, TwoMaterialsAreSpringsInSeries) {
    const int n = 5;
    const TetMesh mesh = make_cube(n, 1.0);
    const Lame soft = Lame::from_young(1e3, 0.3), hard = Lame::from_young(1e5, 0.499);
    Materials material;
    for (const Tet& tet : mesh.tet) {
        double z = 0.0;
        for (std::int32_t i : tet) z += 0.25 * mesh.position_m[static_cast<std::size_t>(i)].z();
        material.push_back(z < 0.5 ? soft : hard);
    }
    const Problem problem =
        assemble_where(mesh, material, Element::kAverageNodalPressure, [](const Vector3d& p) { return p.z() > 0.0; });
    const Matrix k = problem.k();
    const auto count = static_cast<Eigen::Index>(problem.node.size());
    const auto up = Eigen::seqN(2, count, 3);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * count);
    for (Eigen::Index i = 0; i < count; ++i) {
        const double z = mesh.position_m[static_cast<std::size_t>(problem.node[static_cast<std::size_t>(i)])].z();
        u[3 * i + 2] = std::min(z, 0.5) / (soft.lambda_pa + 2.0 * soft.mu_pa) +
                       std::max(z - 0.5, 0.0) / (hard.lambda_pa + 2.0 * hard.mu_pa);
    }
    const Eigen::VectorXd force = (k * u)(up);  // a stress of 1 Pa: balanced inside, 1 N in all on the top
    double top = 0.0;
    const double size = (k.cwiseAbs() * u.cwiseAbs()).maxCoeff();
    for (Eigen::Index i = 0; i < count; ++i)
        if (mesh.position_m[static_cast<std::size_t>(problem.node[static_cast<std::size_t>(i)])].z() < 1.0 - 1e-9)
            EXPECT_WITHIN(std::abs(force[i]), .count = 64.0, .size = size);
        else
            top += force[i];
    EXPECT_WITHIN(std::abs(top - 1.0), .count = 64.0 * n * n, .size = size);
}

}  // namespace

}  // namespace haptable
