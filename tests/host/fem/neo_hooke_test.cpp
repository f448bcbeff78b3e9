// SPDX-License-Identifier: GPL-2.0-or-later
// The orders of a neo-Hookean body's forces, against its energy written out in long double.
#include "host/fem/neo_hooke.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "host/mesh/cube.hpp"
#include "host/mesh/middles.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Real = long double;
using Vector = Eigen::Matrix<Real, 3, 1>;
using Matrix = Eigen::Matrix<Real, 3, 3>;
using Moves = Eigen::Matrix<Real, 3, Eigen::Dynamic>;

/// A lopsided cube of two materials.
class NeoHookeOrders : public ::testing::TestWithParam<Element> {
protected:
    NeoHookeOrders() : mesh_(make_cube(is_quadratic() ? 2 : 3, 1.0)) {
        if (is_quadratic()) add_middles(mesh_);
        std::mt19937 random(5);
        std::uniform_real_distribution<double> shift(-0.08, 0.08);
        // Middles too: curved elements.
        for (auto& x : mesh_.position_m) x += Eigen::Vector3d(shift(random), shift(random), shift(random));
        for (std::size_t t = 0; t < mesh_.tet.size(); ++t)
            material_.push_back(Lame::from_young(t % 2 == 0 ? 3.0 : 5.0, t % 2 == 0 ? 0.45 : 0.3));
    }

    static bool is_quadratic() { return GetParam() == Element::kQuadratic; }
    ElementMesh mesh() const { return {GetParam(), mesh_.position_m, mesh_.tet, material_, mesh_.middle}; }
    Eigen::Index nodes() const { return Eigen::Index(mesh_.position_m.size()); }

    /// Displacements with gradients of about 1.
    Eigen::Matrix3Xd some_moves(unsigned seed) const {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> move(-0.15, 0.15);
        Eigen::Matrix3Xd u(3, nodes());
        for (double& x : u.reshaped()) x = move(random);
        return u;
    }

    /// dx/dt of an element's nodes at a point with barycentric coordinates t, from its shape functions.
    Matrix jacobian(std::size_t element, const std::array<Real, 4>& t, const Moves& x) const {
        Matrix jacobian = Matrix::Zero();
        const auto add = [&](std::int32_t node, const std::array<Real, 4>& by_t) {
            for (int i = 0; i < 3; ++i) jacobian.col(i) += (by_t[std::size_t(i) + 1] - by_t[0]) * x.col(node);
        };
        for (std::size_t c = 0; c < 4; ++c) {
            std::array<Real, 4> by_t{};
            by_t[c] = is_quadratic() ? 4 * t[c] - 1 : 1;
            add(mesh_.tet[element][c], by_t);
        }
        constexpr std::array<std::array<std::size_t, 2>, 6> kEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
        for (std::size_t e = 0; e < 6 && is_quadratic(); ++e) {
            std::array<Real, 4> by_t{};
            by_t[kEdges[e][0]] = 4 * t[kEdges[e][1]];
            by_t[kEdges[e][1]] = 4 * t[kEdges[e][0]];
            add(mesh_.middle[element][e], by_t);
        }
        return jacobian;
    }

    /// W. What an element keeps of lambda stands here a second time: 0.5 mu at most where nodes average.
    Real energy(const Moves& u) const {
        Real sum = 0;
        std::map<std::pair<std::int32_t, double>, std::array<Real, 2>> cell;  // node, lambda: sums of V, V (J - 1)
        const auto own = [&](const Lame& m) {
            return GetParam() == Element::kLinear ? m.lambda_pa : std::min(m.lambda_pa, 0.5 * m.mu_pa);
        };
        std::map<double, Real> left;
        Moves x(3, nodes());
        for (Eigen::Index i = 0; i < nodes(); ++i) x.col(i) = mesh_.position_m[std::size_t(i)].cast<Real>();
        const Real root = std::sqrt(Real(5)), far = (5 + 3 * root) / 20, near = (5 - root) / 20;
        for (std::size_t element = 0; element < mesh_.tet.size(); ++element) {
            const Lame& m = material_[element];
            left[m.lambda_pa] = m.lambda_pa - own(m);
            for (std::size_t q = 0; q < (is_quadratic() ? 4U : 1U); ++q) {
                std::array<Real, 4> t{0.25L, 0.25L, 0.25L, 0.25L};
                if (is_quadratic()) {
                    t.fill(near);
                    t[q] = far;
                }
                const Matrix rest = jacobian(element, t, x), now = jacobian(element, t, x + u),
                             f = now * rest.inverse();
                const Real volume = rest.determinant() / (is_quadratic() ? 24 : 6), j = f.determinant();
                const Real kappa = own(m) + Real(2) / 3 * m.mu_pa;
                sum += volume *
                       (Real(m.mu_pa) / 2 * (f.squaredNorm() / std::cbrt(j * j) - 3) + kappa / 2 * (j - 1) * (j - 1));
                for (std::size_t c = 0; c < 4; ++c) {
                    auto& sums = cell[{mesh_.tet[element][c], m.lambda_pa}];
                    sums[0] += volume * t[c];
                    sums[1] += volume * t[c] * (j - 1);
                }
            }
        }
        for (const auto& [key, sums] : cell) sum += left[key.second] / 2 * sums[1] * sums[1] / sums[0];
        return sum;
    }

    /// w . f(t u), by a difference of the energy.
    Real force_along(const Eigen::Matrix3Xd& w, const Eigen::Matrix3Xd& u, Real t) const {
        constexpr Real kStep = 1e-4L;
        const auto at = [&](Real s) { return energy(t * u.cast<Real>() + s * w.cast<Real>()); };
        return (8 * (at(kStep) - at(-kStep)) - (at(2 * kStep) - at(-2 * kStep))) / (12 * kStep);
    }

    TetMesh mesh_;
    std::vector<Lame> material_;
};

TEST_P(NeoHookeOrders, FirstIsTheLinearBodys) {
    std::vector<std::int32_t> all;
    for (std::int32_t i = 0; i < nodes(); ++i) all.push_back(i);
    const StiffnessParts parts = assemble_stiffness(mesh(), all, std::int32_t(nodes()));
    const Eigen::Matrix3Xd u = some_moves(1);
    const Eigen::VectorXd gu = parts.g * u.reshaped();
    const Eigen::VectorXd ku = parts.a * u.reshaped() + parts.g.transpose() * gu;
    const Eigen::Matrix3Xd first = NeoHooke(mesh()).force_orders(u).force_n[0];
    EXPECT_WITHIN((first.reshaped() - ku).norm(), .count = 60, .size = ku.norm());
}

TEST_P(NeoHookeOrders, SecondAndThirdAreTheEnergys) {
    const Eigen::Matrix3Xd u = some_moves(2);
    const ForceOrders f = NeoHooke(mesh()).force_orders(u);
    // f(t) = f_1 t + ... : the even part begins with f_2, the odd one with f_1, f_3. Remainders of order t^4, and 6
    // after one step of Richardson's; each order of t has a factor of about 3 over the one before.
    constexpr Real kT = 0.01L;
    for (unsigned seed = 3; seed < 8; ++seed) {
        const Eigen::Matrix3Xd w = some_moves(seed);
        const auto along = [&](std::size_t k) { return (w.array() * f.force_n[k].array()).sum(); };
        const auto even = [&](Real t) { return (force_along(w, u, t) + force_along(w, u, -t)) / (2 * t * t); };
        const auto odd = [&](Real t) {
            return (force_along(w, u, t) - force_along(w, u, -t)) / (2 * t * t * t) - along(0) / double(t * t);
        };
        const auto limit = [&](const auto& part) { return double((4 * part(kT) - part(2 * kT)) / 3); };
        const double size = w.norm() * f.force_n[1].norm();
        // 4 t^4 3^4, and roundings of K u in double over t^2
        EXPECT_WITHIN(std::abs(limit(even) - along(1)), .epsilon = 1e-5, .size = size) << seed;
        EXPECT_WITHIN(std::abs(limit(odd) - along(2)), .epsilon = 1e-4, .size = w.norm() * f.force_n[2].norm()) << seed;
    }
}

INSTANTIATE_TEST_SUITE_P(Elements, NeoHookeOrders, ::testing::ValuesIn(every<Element>()));

}  // namespace
}  // namespace haptable::test
