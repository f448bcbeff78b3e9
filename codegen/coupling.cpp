// SPDX-License-Identifier: GPL-2.0-or-later
// C <- C + I / k: a spring in series with the object, in its tables. It costs nothing at run time.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "codegen/model.hpp"
#include "firmware/haptable.h"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Block = std::array<float, 6>;

constexpr double kPeriod_s = HAPTABLE_TICK_US / 1e6;
// A fast exploring hand. Above it the device's friction no longer covers what the sampled spring gives.
constexpr double kSpeed_m_s = 0.5;

Matrix3d unpacked(const Block& s) {
    const auto d = [&](std::size_t i) { return static_cast<double>(s[i]); };
    Matrix3d m;
    m << d(0), d(3), d(5), d(3), d(1), d(4), d(5), d(4), d(2);
    return m;
}

Block packed_again(const Matrix3d& m) {
    return {static_cast<float>(m(0, 0)), static_cast<float>(m(1, 1)), static_cast<float>(m(2, 2)),
            static_cast<float>(m(0, 1)), static_cast<float>(m(1, 2)), static_cast<float>(m(0, 2))};
}

double largest_eigenvalue(const Matrix3d& m) {
    return Eigen::SelfAdjointEigenSolver<Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues()[2];
}
double smallest_eigenvalue(const Matrix3d& m) {
    return Eigen::SelfAdjointEigenSolver<Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

double factorial(int n) {
    double product = 1.0;
    for (int k = 2; k <= n; ++k) product *= k;
    return product;
}

/// The block of a patch's control point with these exponents.
const Block& control_block(const ServoModel& model, std::size_t patch, const std::array<int, 3>& n) {
    const ServoCompliance& c = model.compliance;
    const auto& v = model.patch[patch];
    const auto per_edge = static_cast<std::size_t>(c.degree - 1);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
        if (n[k] == c.degree) return c.vertex_m_per_n[v[k]];
        if (n[k] != 0 || n[a] == 0 || n[b] == 0) continue;
        const auto from_low = static_cast<std::size_t>((v[a] < v[b] ? n[b] : n[a]) - 1);
        return c.edge_m_per_n[c.patch_edge[patch][k] * per_edge + from_low];
    }
    const auto corner = static_cast<std::size_t>(n[0] == 2 ? 0 : n[1] == 2 ? 1 : 2);
    return c.patch_m_per_n[3 * patch + corner];
}

/// C(alpha) of a patch, by Bernstein's formula; fixed vertices lift it as the firmware does.
Matrix3d compliance_at(const ServoModel& model, std::size_t patch, const std::array<double, 3>& alpha) {
    const int degree = model.compliance.degree;
    Matrix3d sum = Matrix3d::Zero();
    double fixed = 0.0;
    for (int i = 0; i <= degree; ++i)
        for (int j = 0; i + j <= degree; ++j) {
            const std::array<int, 3> n{i, j, degree - i - j};
            double weight = factorial(degree);
            for (std::size_t k = 0; k < 3; ++k) weight *= std::pow(alpha[k], n[k]) / factorial(n[k]);
            sum += weight * unpacked(control_block(model, patch, n));
        }
    for (std::size_t k = 0; k < 3; ++k)
        if (model.patch[patch][k] >= model.free_count) fixed += alpha[k];
    if (fixed > 0.0)
        sum += std::max(0.0, fixed / static_cast<double>(model.rigid_stiffness_n_per_m) - sum.trace() / 3.0) *
               Matrix3d::Identity();
    return sum;
}

/// Of the points of a grid of eighths on every patch.
double largest_of_compliance(const ServoModel& model) {
    constexpr int kSteps = 8;
    double largest = 0.0;
    for (std::size_t p = 0; p < model.patch.size(); ++p)
        for (int i = 0; i <= kSteps; ++i)
            for (int j = 0; i + j <= kSteps; ++j) {
                const auto fraction = [](int n) { return static_cast<double>(n) / kSteps; };
                const Matrix3d c = compliance_at(model, p, {fraction(i), fraction(j), fraction(kSteps - i - j)});
                largest = std::max(largest, 1.0 / smallest_eigenvalue(c));
            }
    return largest;
}

/// S is a mean of the vertices' blocks, so none of its eigenvalues is larger than the largest of theirs.
double largest_of_vertices(const ServoModel& model) {
    double largest = model.free_count < model.node.size() ? static_cast<double>(model.rigid_stiffness_n_per_m) : 0.0;
    for (const Block& s : model.stiffness_n_per_m) largest = std::max(largest, largest_eigenvalue(unpacked(s)));
    return largest;
}

/// A spring K that is sampled every T and held gives at most K s^2 / 2 over a motion s of one tick; the device's
/// damping b takes b s^2 / T (Colgate and Schenkel 1997: K < 2 b / T) and its Coulomb friction c |s|; an encoder step D
/// hides motions up to D (Diolaiti, Niemeyer, Barbagli and Salisbury 2006: K < 2 c / D). Together, for motions up to v
/// T:
double stable_stiffness(const Tables& tables) {
    const double motion_m = std::max(tables.encoder_step_m, kSpeed_m_s * kPeriod_s);
    return 2.0 * tables.damping_n_s_per_m / kPeriod_s + 2.0 * tables.device_friction_n / motion_m;
}

void put_in_series(double compliance_m_per_n, ServoModel& model) {
    const Matrix3d more = compliance_m_per_n * Matrix3d::Identity();
    for (Block& s : model.stiffness_n_per_m) s = packed_again((unpacked(s).inverse() + more).inverse());
    for (auto* blocks :
         {&model.compliance.vertex_m_per_n, &model.compliance.edge_m_per_n, &model.compliance.patch_m_per_n})
        for (Block& c : *blocks) c = packed_again(unpacked(c) + more);
    model.rigid_stiffness_n_per_m =
        static_cast<float>(1.0 / (1.0 / static_cast<double>(model.rigid_stiffness_n_per_m) + compliance_m_per_n));
}

}  // namespace

void couple(const Tables& tables, ServoModel& model) {
    const auto largest = [&] {
        return model.compliance.degree == 0 ? largest_of_vertices(model) : largest_of_compliance(model);
    };
    ServoStiffness& k = model.stiffness;
    k.largest_n_per_m = k.felt_n_per_m = largest();
    k.stable_n_per_m = stable_stiffness(tables);
    double compliance = tables.coupling_n_per_m > 0.0 ? 1.0 / tables.coupling_n_per_m : 0.0;
    if (tables.auto_coupling && k.stable_n_per_m > 0.0)
        compliance = std::max(0.0, 1.0 / k.stable_n_per_m - 1.0 / k.largest_n_per_m);
    double all = 0.0;
    // Where fixed vertices lift C, the lift changes with it: a second spring, much weaker, makes up for that.
    for (int more = 0; more < 8 && compliance > 0.0; ++more) {
        put_in_series(compliance, model);
        all += compliance;
        k.coupling_n_per_m = 1.0 / all;
        k.felt_n_per_m = largest();
        compliance = tables.auto_coupling && k.felt_n_per_m > k.stable_n_per_m * (1.0 + 1e-6)
                         ? 1.0 / k.stable_n_per_m - 1.0 / k.felt_n_per_m
                         : 0.0;
    }
}

}  // namespace haptable
