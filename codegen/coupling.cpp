// SPDX-License-Identifier: GPL-2.0-or-later
// C <- C + I / k: a spring in series with the object, in its tables. It costs nothing at run time.
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "codegen/model.hpp"
#include "codegen/polynomial.hpp"
#include "firmware/haptable_model.h"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using HalfBlock = std::array<float, 6>;

constexpr double kPeriod_s = HAPTABLE_TICK_US / 1e6;
// A fast exploring hand. Above it the device's friction no longer covers what the sampled spring gives.
constexpr double kSpeed_m_s = 0.5;

HalfBlock packed_again(const Matrix3d& m) {
    return {static_cast<float>(m(0, 0)), static_cast<float>(m(1, 1)), static_cast<float>(m(2, 2)),
            static_cast<float>(m(0, 1)), static_cast<float>(m(1, 2)), static_cast<float>(m(0, 2))};
}

double largest_eigenvalue(const Matrix3d& m) {
    return Eigen::SelfAdjointEigenSolver<Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues()[2];
}
double smallest_eigenvalue(const Matrix3d& m) {
    return Eigen::SelfAdjointEigenSolver<Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

/// Points of a grid of eighths.
std::vector<BernsteinPoint> grid_of(int degree) {
    constexpr int kSteps = 8;
    const auto fraction = [](int n) { return static_cast<double>(n) / kSteps; };
    std::vector<BernsteinPoint> grid;
    for (int i = 0; i <= kSteps; ++i)
        for (int j = 0; i + j <= kSteps; ++j)
            grid.emplace_back(degree, std::array{fraction(i), fraction(j), fraction(kSteps - i - j)});
    return grid;
}

/// True where every eigenvalue of a symmetric C is surely above the bound: C - bound I has positive pivots.
bool all_above(const Matrix3d& c, double bound) {
    const double a = c(0, 0) - bound, b = c(1, 1) - bound - c(1, 0) * c(1, 0) / a;
    const double l = c(2, 1) - c(1, 0) * c(2, 0) / a;
    return a > 0.0 && b > 0.0 && c(2, 2) - bound - c(2, 0) * c(2, 0) / a - l * l / b > 0.0;
}

/// Largest at the points of a grid on every patch.
double largest_of_compliance(const ServoModel& model) {
    constexpr double kSurely = 1.0 + 1e-6;  // far beyond the rounding of all_above
    const std::vector<BernsteinPoint> grid = grid_of(model.compliance.degree);
    const std::vector<HalfBlock> blocks = compliance_blocks(model);
    double largest = 0.0;
    for (std::size_t p = 0; p < model.patch.size(); ++p) {
        std::vector<Matrix3d> control;
        for (std::size_t b : control_blocks(model, p)) control.push_back(symmetric(blocks[b]));
        for (const BernsteinPoint& point : grid) {
            const Matrix3d c = compliance_at(model, p, control, point);
            if (largest > 0.0 && all_above(c, kSurely / largest)) continue;
            largest = std::max(largest, 1.0 / smallest_eigenvalue(c));
        }
    }
    return largest;
}

/// S is a mean of the vertices' blocks, so none of its eigenvalues is larger than the largest of theirs.
double largest_of_vertices(const ServoModel& model) {
    double largest = model.free_count < model.node.size() ? static_cast<double>(model.rigid_stiffness_n_per_m) : 0.0;
    for (const HalfBlock& s : model.stiffness_n_per_m) largest = std::max(largest, largest_eigenvalue(symmetric(s)));
    return largest;
}

void put_in_series(double compliance_m_per_n, ServoModel& model) {
    const Matrix3d more = compliance_m_per_n * Matrix3d::Identity();
    for (HalfBlock& s : model.stiffness_n_per_m) s = packed_again((symmetric(s).inverse() + more).inverse());
    for (auto* blocks : {&model.compliance.vertex, &model.compliance.edge, &model.compliance.patch})
        for (HalfBlock& c : *blocks) c = packed_again(symmetric(c) + more);
    model.rigid_stiffness_n_per_m =
        static_cast<float>(1.0 / (1.0 / static_cast<double>(model.rigid_stiffness_n_per_m) + compliance_m_per_n));
}

}  // namespace

// A spring K that is sampled every T, held, and felt d later gives at most K (T/2 + d) v^2 a second at a speed v; the
// device's damping b takes b v^2 (Colgate and Schenkel 1997: K < 2 b / T; with a delay Gil, Sanchez, Hulin, Preusche
// and Hirzinger 2009: K < b / (T/2 + d)) and its Coulomb friction c v; an encoder step D hides motions up to D
// (Diolaiti, Niemeyer, Barbagli and Salisbury 2006: K < 2 c / D). Together, for motions up to v T; a body of stiffness
// S feels motion scale x force scale x S stiff to the hand:
double stable_stiffness(const Tables& tables) {
    const double motion_m = std::max(tables.encoder_step_m, kSpeed_m_s * kPeriod_s);
    const double takes_n_s_per_m = tables.damping_n_s_per_m + tables.device_friction_n * kPeriod_s / motion_m;
    return takes_n_s_per_m / (kPeriod_s / 2.0 + tables.device_delay_s) / (tables.motion_scale * tables.force_scale);
}

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
    // The hand meets the tangent of a dent that stiffens, at the deepest one that the motors press against.
    const double deepest_j = tables.stiffening.energy_at(tables.max_force_n, k.felt_n_per_m);
    k.felt_n_per_m *= tables.stiffening.largest_tangent(deepest_j);
}

}  // namespace haptable
