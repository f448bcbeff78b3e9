// SPDX-License-Identifier: GPL-2.0-or-later
// Tetrahedra, linear and quadratic, against the textbook's; and those that average their change of volume at the
// corners, as a discretisation.
#include "host/fem/nodal_pressure.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <tuple>

#include "host/inverse/factor.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/middles.hpp"
#include "tests/dense.hpp"
#include "tests/host/fem/jittered_cube.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::Vector3d;
using Matrix = Eigen::MatrixXd;
using Materials = std::vector<Lame>;
constexpr double kPi = std::numbers::pi;
using test::jittered_cube;
constexpr std::array kElements{Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic};
constexpr std::array kAveraging{Element::kAverageNodalPressure, Element::kQuadratic};

ElementMesh element_mesh(const TetMesh& mesh, const Materials& material, Element element) {
    return {element, mesh.position_m, mesh.tet, material, mesh.middle};
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
        problem.unknown.push_back(free ? std::int32_t(problem.node.size()) : -1);
        if (free) problem.node.push_back(std::int32_t(i));
    }
    problem.parts =
        assemble_stiffness(element_mesh(mesh, material, element), problem.unknown, std::int32_t(problem.node.size()));
    return problem;
}
Matrix free_stiffness(const TetMesh& mesh, const Lame& lame, Element element) {
    const auto all = [](const Vector3d&) { return true; };
    return assemble_where(mesh, Materials(mesh.tet.size(), lame), element, all).k();
}

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

Matrix rigid_motions(const TetMesh& mesh, double side) {
    Matrix rigid(3 * Eigen::Index(mesh.position_m.size()), 6);
    for (Eigen::Index i = 0; i < rigid.rows() / 3; ++i) {
        rigid.block<3, 3>(3 * i, 0).setIdentity();
        for (int axis = 0; axis < 3; ++axis)
            rigid.block<3, 1>(3 * i, 3 + axis) = Vector3d::Unit(axis).cross(mesh.position_m[std::size_t(i)] / side);
    }
    return rigid;
}

TEST(NodalPressure, RigidMotionsAreTheNullSpaceOfTheFreeStiffness) {
    for (Element element : kElements)
        for (double poisson : {-0.5, 0.3, 0.4999})
            for (double side : {0.03e-3, 0.03, 0.03e3}) {
                const TetMesh mesh = jittered_cube(element == Element::kQuadratic ? 3 : 4, side, element);
                const Lame lame = Lame::from_young(1e4, poisson);
                const Matrix k = free_stiffness(mesh, lame, element);
                EXPECT_EQ(k, Matrix(k.transpose()));
                const Matrix rigid = rigid_motions(mesh, side);
                const Eigen::VectorXd eigenvalue = dense::eigenvalues(k);
                const double largest = eigenvalue[k.rows() - 1];
                const double count = 4.0 * std::sqrt(k.rows());  // as of linear tetrahedra: entries of a row
                EXPECT_WITHIN(dense::product(k, rigid).colwise().norm().maxCoeff() /
                                  (largest * rigid.colwise().norm().minCoeff()),
                              .count = count);
                EXPECT_WITHIN(std::abs(eigenvalue[5]) / largest, .count = count);
                // Averaging leaves no motion without energy: the shear part resists whatever strains an element.
                EXPECT_GT(eigenvalue[6] / (lame.mu_pa * side), 1e-3);
            }
}

/// C3D10 of every textbook: lambda stays with the elements.
Matrix plain_quadratic_stiffness(const TetMesh& mesh, const Lame& lame) {
    const auto size = 3 * Eigen::Index(mesh.position_m.size());
    Matrix sum = Matrix::Zero(size, size);
    for (std::size_t t = 0; t < mesh.tet.size(); ++t) {
        const auto k = element_stiffness(ten_nodes(mesh.position_m, mesh.tet[t], mesh.middle[t]), lame);
        std::vector<Eigen::Index> rows;
        for_each_node(mesh, t, [&](Eigen::Index node) {
            rows.insert(rows.end(), {3 * node, 3 * node + 1, 3 * node + 2});
        });
        sum(rows, rows) += k;
    }
    return sum;
}

// Up to a sixth lambda is at most mu / 2, and there is nothing to average: the element is the textbook's.
TEST(NodalPressure, NoMotionStoresMoreThanWithoutAveragingWhichBeginsAtPoissonsRatioOfASixth) {
    for (Element element : kAveraging) {
        const bool is_quadratic = element == Element::kQuadratic;
        const TetMesh mesh = jittered_cube(is_quadratic ? 3 : 4, 0.03, element);
        for (double poisson : {-0.5, 0.0, 0.16, 0.18, 0.3, 0.4999}) {
            SCOPED_TRACE(testing::Message() << element << ", nu = " << poisson);
            const Lame lame = Lame::from_young(1e4, poisson);
            const Matrix plain =
                is_quadratic ? plain_quadratic_stiffness(mesh, lame) : free_stiffness(mesh, lame, Element::kLinear);
            const Matrix averaged = free_stiffness(mesh, lame, element);
            EXPECT_WITHIN(-dense::eigenvalues(plain - averaged)[0] / plain.norm(), .count = 64.0);
            const double off = (plain - averaged).norm() / plain.norm();
            if (poisson < 1.0 / 6.0)
                EXPECT_WITHIN(off, .count = is_quadratic ? 64.0 : 0.0);
            else
                EXPECT_GT(off, 1e-3);
        }
    }
}

// In the textbook's form: shape functions and their derivatives written out, Hooke's law as a matrix of 6 by 6.
TEST(NodalPressure, TheQuadraticElementAgreesWithTheTextbook) {
    TetMesh mesh = jittered_cube(3, 0.03, Element::kQuadratic);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> shift(-0.0005, 0.0005);
    for (std::size_t i = 27; i < mesh.position_m.size(); ++i)  // curved: a thirtieth of an edge
        mesh.position_m[i] += Vector3d(shift(random), shift(random), shift(random));
    const Lame lame = Lame::from_young(1e4, 0.3);
    Matrix hooke = Matrix::Zero(6, 6);
    hooke.topLeftCorner<3, 3>().setConstant(lame.lambda_pa);
    hooke.diagonal().head<3>().array() += 2.0 * lame.mu_pa;
    hooke.diagonal().tail<3>().setConstant(lame.mu_pa);
    const double p = 0.58541020, q = 0.13819660;  // as printed
    for (std::size_t t = 0; t < mesh.tet.size(); ++t) {
        const TenNodes x = ten_nodes(mesh.position_m, mesh.tet[t], mesh.middle[t]);
        Matrix expected = Matrix::Zero(30, 30);
        for (int point = 0; point < 4; ++point) {
            const double r = point == 1 ? p : q, s = point == 2 ? p : q, u = point == 3 ? p : q, l = 1 - r - s - u;
            Matrix d(3, 10);                                                                // by r, s, u
            d << 1 - 4 * l, 4 * r - 1, 0, 0, 4 * (l - r), 4 * s, -4 * s, -4 * u, 4 * u, 0,  //
                1 - 4 * l, 0, 4 * s - 1, 0, -4 * r, 4 * r, 4 * (l - s), -4 * u, 0, 4 * u,   //
                1 - 4 * l, 0, 0, 4 * u - 1, -4 * r, 0, -4 * s, 4 * (l - u), 4 * r, 4 * s;
            const Eigen::Matrix3d jacobian = dense::product(d, x.transpose());
            const Matrix g = dense::product(jacobian.inverse(), d);
            Matrix b = Matrix::Zero(6, 30);
            for (int a = 0; a < 10; ++a) {
                for (int c = 0; c < 3; ++c) b(c, 3 * a + c) = g(c, a);
                b.block<3, 3>(3, 3 * a) << g(1, a), g(0, a), 0, 0, g(2, a), g(1, a), g(2, a), 0, g(0, a);
            }
            expected += jacobian.determinant() / 24.0 * transposed_product(b, dense::product(hooke, b));
        }
        // The printed points have eight digits.
        ASSERT_WITHIN((element_stiffness(x, lame) - expected).norm() / expected.norm(), .count = 8, .epsilon = 1e-8);
    }
}

/// Displaces the boundary by u = A x and solves for the inner nodes.
double patch_test_error(Element element, const Lame& lame, const Eigen::Matrix3d& a, double side) {
    const TetMesh mesh = jittered_cube(element == Element::kQuadratic ? 3 : 5, side, element);
    const Matrix k = free_stiffness(mesh, lame, element);
    std::vector<Eigen::Index> inner;
    Eigen::VectorXd u(k.rows());
    for (std::size_t i = 0; i < mesh.position_m.size(); ++i) {
        const auto row = 3 * Eigen::Index(i);
        u.segment<3>(row) = a * mesh.position_m[i];
        if (test::is_inside_cube(mesh.position_m[i], side)) inner.insert(inner.end(), {row, row + 1, row + 2});
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
    for (Element element : kElements)
        for (double poisson : {0.3, 0.49, 0.4999})
            for (double side : {0.03e-3, 0.03, 0.03e3})
                EXPECT_LT(patch_test_error(element, Lame::from_young(1e4, poisson), a, side), 1e-10)
                    << element << ", nu = " << poisson;
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
        for (std::int32_t i : tet) volume[std::size_t(i)] += six_volumes(mesh.position_m, tet) / 24.0;
    return volume;
}

/// Calls visit(x, dv, node, shape): the points of a Gauss product rule on each tetrahedron, exact for polynomials of
/// degree 5, and the shape functions of its nodes there.
template <typename Visit>
void for_each_point(const TetMesh& mesh, Visit visit) {
    const double far = std::sqrt(0.6) / 2.0;
    const std::array<std::pair<double, double>, 3> gauss{
        {{0.5 - far, 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 + far, 5.0 / 18}}};
    for (std::size_t k = 0; k < mesh.tet.size(); ++k) {
        std::vector<std::int32_t> node;
        for_each_node(mesh, k, [&](std::int32_t i) { node.push_back(i); });
        for (const auto& [a, wa] : gauss)
            for (const auto& [b, wb] : gauss)
                for (const auto& [c, wc] : gauss) {
                    const Eigen::Vector4d t(1 - a, a * (1 - b), a * b * (1 - c), a * b * c);
                    Vector3d x = Vector3d::Zero();
                    for (int i = 0; i < 4; ++i) x += t[i] * mesh.position_m[std::size_t(mesh.tet[k][std::size_t(i)])];
                    Eigen::VectorXd shape = t;
                    if (node.size() == 10) {
                        shape.resize(10);
                        for (int i = 0; i < 4; ++i) shape[i] = t[i] * (2 * t[i] - 1);
                        for (int e = 0; e < 6; ++e) {
                            const auto [p, q] = kTetEdges[std::size_t(e)];
                            shape[4 + e] = 4 * t[int(p)] * t[int(q)];
                        }
                    }
                    visit(x, wa * wb * wc * a * a * b * six_volumes(mesh.position_m, mesh.tet[k]), node, shape);
                }
    }
}

/// Against the exact solution: of the displacements, as a share; of the elements' pressures and of the corners', by mu.
struct Errors {
    double displacement = 0.0, pressure = 0.0, nodal_pressure = 0.0;
};

/// The body force. A body that is compressed by it would not move as a swirl.
Matrix swirl_load(const TetMesh& mesh, const Problem& problem, double mu, bool with_pressure) {
    Matrix load = Matrix::Zero(3 * Eigen::Index(problem.node.size()), 1);
    for_each_point(mesh, [&](const Vector3d& x, double dv, const auto& node, const Eigen::VectorXd& shape) {
        Vector3d force = -mu * laplacian_of_swirl(x);
        if (with_pressure) force += gradient_of_pressure(x);
        for (std::size_t a = 0; a < node.size(); ++a)
            if (const Eigen::Index i = problem.unknown[std::size_t(node[a])]; i >= 0)
                load.block<3, 1>(3 * i, 0) += dv * shape[Eigen::Index(a)] * force;
    });
    return load;
}

/// In the norm of L2.
double displacement_error(const TetMesh& mesh, const Problem& problem, const Matrix& u) {
    double off = 0.0, size = 0.0;
    for_each_point(mesh, [&](const Vector3d& x, double dv, const auto& node, const Eigen::VectorXd& shape) {
        Vector3d moved = Vector3d::Zero();
        for (std::size_t a = 0; a < node.size(); ++a)
            if (const Eigen::Index i = problem.unknown[std::size_t(node[a])]; i >= 0)
                moved += shape[Eigen::Index(a)] * u.block<3, 1>(3 * i, 0);
        off += dv * (moved - swirl(x)).squaredNorm();
        size += dv * swirl(x).squaredNorm();
    });
    return std::sqrt(off / size);
}

/// Nodal pressures are -(lambda - lambda_e) theta with G u = sqrt((lambda - lambda_e) V) theta; an element feels the
/// mean of its four.
void find_pressure_errors(const TetMesh& mesh, const Problem& problem, double lambda, const Matrix& u, Errors& errors) {
    const std::vector<double> node_volume = node_volumes(mesh);
    const Eigen::VectorXd g = problem.parts.g * u.col(0);
    std::vector<double> off(node_volume.size());
    double nodal = 0.0, sum = 0.0;
    for (std::size_t row = 0; row < problem.parts.node.size(); ++row) {
        const auto i = std::size_t(problem.parts.node[row]);
        off[i] = -std::sqrt(lambda / node_volume[i]) * g[Eigen::Index(row)] - pressure(mesh.position_m[i]);
        nodal += node_volume[i] * off[i] * off[i];
    }
    for (const Tet& tet : mesh.tet) {
        double mean = 0.0;
        for (std::int32_t i : tet) mean += 0.25 * off[std::size_t(i)];
        sum += mean * mean * six_volumes(mesh.position_m, tet) / 6.0;  // of a cube of volume 1
    }
    errors.pressure = std::sqrt(sum);
    errors.nodal_pressure = std::sqrt(nodal);
}

/// Computed once for all tests: the fine ones take seconds.
const Errors& errors_of(int n, double poisson, Element element) {
    static std::map<std::tuple<int, double, Element>, Errors> known;
    const auto [at, is_new] = known.try_emplace({n, poisson, element});
    Errors& errors = at->second;
    if (!is_new) return errors;
    const TetMesh mesh = jittered_cube(n, 1.0, element);
    const Lame lame = Lame::from_young(2.0 * (1.0 + poisson), poisson);  // mu = 1
    const Problem problem = assemble_where(mesh, Materials(mesh.tet.size(), lame), element,
                                           [](const Vector3d& p) { return test::is_inside_cube(p, 1.0 - 1e-9); });
    const bool with_pressure = poisson > 0.49;
    Matrix u;
    Factor(problem.k()).solve(swirl_load(mesh, problem, lame.mu_pa, with_pressure), u);
    errors.displacement = displacement_error(mesh, problem, u);
    if (with_pressure) find_pressure_errors(mesh, problem, lame.lambda_pa - 0.5 * lame.mu_pa, u, errors);
    return errors;
}

TEST(NodalPressure, DisplacementsConvergeByTheElementsOrderAtAnyPoissonsRatio) {
    for (double poisson : {0.3, 0.4999}) {
        const Errors coarse = errors_of(9, poisson, Element::kAverageNodalPressure);
        const Errors fine = errors_of(17, poisson, Element::kAverageNodalPressure);
        EXPECT_NEAR(std::log2(coarse.displacement / fine.displacement), 2.0, 0.5) << "nu = " << poisson;
        const Errors coarse_quadratic = errors_of(5, poisson, Element::kQuadratic);
        const Errors fine_quadratic = errors_of(9, poisson, Element::kQuadratic);
        EXPECT_NEAR(std::log2(coarse_quadratic.displacement / fine_quadratic.displacement), 3.0, 0.5)
            << "nu = " << poisson;
        EXPECT_LT(fine_quadratic.displacement, 0.5 * fine.displacement) << "with a seventh of the corners";
    }
    EXPECT_GT(errors_of(9, 0.4999, Element::kLinear).displacement, 0.9) << "linear ones hardly move";
}

// Nodal pressures of linear tetrahedra are not stable in the sense of Babuska and Brezzi: from node to node they
// alternate. What counts is that this neither grows with lambda nor with refinement: then displacements, all that the
// tables hold, are sound.
TEST(NodalPressure, TheCheckerboardOfPressureIsBounded) {
    for (Element element : kAveraging) {
        const int n = element == Element::kQuadratic ? 5 : 9;
        const Errors coarse = errors_of(n, 0.4999, element), fine = errors_of(2 * n - 1, 0.4999, element);
        const Errors stiffer = errors_of(n, 0.499999, element);
        EXPECT_LT(fine.pressure, coarse.pressure) << element;
        EXPECT_LT(stiffer.pressure, 5.0 * coarse.pressure) << element << ": lambda is a hundred times as much";
        EXPECT_LT(stiffer.displacement, 2.0 * coarse.displacement) << element;
    }
    // Taylor and Hood's element is stable: nothing alternates, and the corners' own pressures converge.
    for (double poisson : {0.4999, 0.499999})
        EXPECT_LT(errors_of(9, poisson, Element::kQuadratic).nodal_pressure,
                  0.5 * errors_of(5, poisson, Element::kQuadratic).nodal_pressure)
            << "nu = " << poisson;
}

}  // namespace
}  // namespace haptable
