// SPDX-License-Identifier: GPL-2.0-or-later
// The orders of a neo-Hookean body's forces, against its energy written out in long double.
#include "host/fem/neo_hooke.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "host/mesh/cube.hpp"
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
    NeoHookeOrders() : mesh_(make_cube(3, 1.0)) {
        std::mt19937 random(5);
        std::uniform_real_distribution<double> shift(-0.08, 0.08);
        for (auto& x : mesh_.position_m) x += Eigen::Vector3d(shift(random), shift(random), shift(random));
        for (std::size_t t = 0; t < mesh_.tet.size(); ++t)
            material_.push_back(Lame::from_young(t % 2 == 0 ? 3.0 : 5.0, t % 2 == 0 ? 0.45 : 0.3));
    }

    ElementMesh mesh() const { return {GetParam(), mesh_.position_m, mesh_.tet, material_}; }
    Eigen::Index nodes() const { return static_cast<Eigen::Index>(mesh_.position_m.size()); }

    /// Displacements with gradients of about 1.
    Eigen::Matrix3Xd some_moves(unsigned seed) const {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> move(-0.15, 0.15);
        Eigen::Matrix3Xd u(3, nodes());
        for (double& x : u.reshaped()) x = move(random);
        return u;
    }

    /// W. What an element keeps of lambda stands here a second time: mu / 2 at most where nodes average.
    Real energy(const Moves& u) const {
        Real sum = 0;
        std::map<std::pair<std::int32_t, double>, std::array<Real, 2>> cell;  // node, lambda: sums of V, V (J - 1)
        const auto own = [&](const Lame& m) {
            return GetParam() == Element::kLinear ? m.lambda_pa : std::min(m.lambda_pa, m.mu_pa / 2);
        };
        std::map<double, Real> left;
        for (std::size_t t = 0; t < mesh_.tet.size(); ++t) {
            const Lame& m = material_[t];
            Matrix x, y;
            for (int c = 0; c < 3; ++c) {
                const auto a = mesh_.tet[t][0], b = mesh_.tet[t][static_cast<std::size_t>(c) + 1];
                x.col(c) =
                    (mesh_.position_m[static_cast<std::size_t>(b)] - mesh_.position_m[static_cast<std::size_t>(a)])
                        .cast<Real>();
                y.col(c) = x.col(c) + u.col(b) - u.col(a);
            }
            const Real volume = x.determinant() / 6, j = y.determinant() / x.determinant();
            const Matrix f = y * x.inverse();
            const Real kappa = own(m) + Real(2) / 3 * m.mu_pa;
            sum +=
                volume * (Real(m.mu_pa) / 2 * (f.squaredNorm() / std::cbrt(j * j) - 3) + kappa / 2 * (j - 1) * (j - 1));
            left[m.lambda_pa] = m.lambda_pa - own(m);
            for (std::int32_t node : mesh_.tet[t]) {
                cell[{node, m.lambda_pa}][0] += volume / 4;
                cell[{node, m.lambda_pa}][1] += volume / 4 * (j - 1);
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
    const StiffnessParts parts = assemble_stiffness(mesh(), all, static_cast<std::int32_t>(nodes()));
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
            return (force_along(w, u, t) - force_along(w, u, -t)) / (2 * t * t * t) -
                   along(0) / static_cast<double>(t * t);
        };
        const auto limit = [&](const auto& part) { return static_cast<double>((4 * part(kT) - part(2 * kT)) / 3); };
        const double size = w.norm() * f.force_n[1].norm();
        // 4 t^4 3^4, and roundings of K u in double over t^2
        EXPECT_WITHIN(std::abs(limit(even) - along(1)), .epsilon = 1e-5, .size = size) << seed;
        EXPECT_WITHIN(std::abs(limit(odd) - along(2)), .epsilon = 1e-4, .size = w.norm() * f.force_n[2].norm()) << seed;
    }
}

INSTANTIATE_TEST_SUITE_P(Elements, NeoHookeOrders, ::testing::Values(Element::kLinear, Element::kAverageNodalPressure),
                         [](const auto& element) {
                             return element.param == Element::kLinear ? "Linear" : "AverageNodalPressure";
                         });

}  // namespace
}  // namespace haptable::test
