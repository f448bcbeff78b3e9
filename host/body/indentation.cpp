// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/indentation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "host/body/assembly.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kAtRest = 1e-5;           // of the force: what may be missing at the nodes, in the metric of K^-1
constexpr std::size_t kKept = 12;          // pairs
constexpr double kArmijo = 1e-4;           // of the slope: least descent of a step
constexpr double kLeastPart = 1e-6;        // of a step
constexpr double kRoundingOfWork = 1e-14;  // of W
constexpr double kCurvature = 1e-12;       // least s . y of a pair that is kept, of |s| |y|

}  // namespace

Indentation::Indentation(const Hyperelastic& body, const LinearSolver& solver, std::span<const std::int32_t> unknown,
                         const NodeWeights& load)
    : body_(&body), solver_(&solver), unknown_(unknown) {
    w_ = load_matrix(load, unknown, solver.size());
    solver.solve(w_, x_);
    stiffness_ = Eigen::Matrix3d(transposed_product(w_, x_)).inverse();
    rest_.x = VectorXd::Zero(solver.size());
}

/// False where an element is turned over.
bool Indentation::evaluate(State& state) const {
    Matrix3Xd f;
    state.energy_j = body_->energy(spread(state.x, unknown_), f);
    if (!std::isfinite(state.energy_j)) return false;
    state.gradient = gather(f, unknown_, state.x.size());
    return true;
}

VectorXd Indentation::projected(const VectorXd& g, Vector3d& finger_n) const {
    MatrixXd z;
    solver_->solve(MatrixXd(g), z);
    finger_n = stiffness_ * transposed_product(w_, z);
    return z.col(0) - x_ * finger_n;
}

/// Nocedal's two loops, about K^-1 with the scale of the last pair.
VectorXd Indentation::direction(const State& state, const std::deque<Pair>& kept) const {
    if (kept.empty()) return state.free;
    VectorXd q = state.gradient;
    std::vector<double> a(kept.size());
    for (std::size_t k = kept.size(); k-- > 0;) {
        a[k] = kept[k].per_sy * kept[k].s.dot(q);
        q -= a[k] * kept[k].y;
    }
    const Pair& last = kept.back();
    Vector3d unused;
    VectorXd p = projected(q, unused) / (last.per_sy * last.y.dot(projected(last.y, unused)));
    for (std::size_t k = 0; k < kept.size(); ++k) p += kept[k].s * (a[k] - kept[k].per_sy * kept[k].y.dot(p));
    return p;
}

/// Armijo's condition. slope: of W along -down, < 0.
std::optional<Indentation::State> Indentation::line_search(const State& from, const VectorXd& down,
                                                           double slope) const {
    double part = 2.0;
    while ((part *= 0.5) > kLeastPart) {
        State next;
        next.x = from.x - part * down;
        const double most_j = from.energy_j + kArmijo * part * slope + kRoundingOfWork * std::abs(from.energy_j);
        if (!evaluate(next) || next.energy_j > most_j) continue;
        next.free = projected(next.gradient, next.finger_n);
        return next;
    }
    return {};
}

std::optional<Indentation::State> Indentation::find_rest(State state, const Vector3d& d) const {
    if (!evaluate(state)) return {};
    state.free = projected(state.gradient, state.finger_n);
    std::deque<Pair> kept;
    for (int step = 0; step < kMostSteps; ++step) {
        const double missing2 = state.free.dot(state.gradient);
        if (missing2 <= kAtRest * kAtRest * state.finger_n.dot(d)) return state;
        VectorXd down = direction(state, kept);
        if (!(down.dot(state.gradient) > 0.0)) {
            kept.clear();
            down = state.free;
        }
        std::optional<State> next = line_search(state, down, -down.dot(state.gradient));
        if (!next) return {};
        Pair pair{next->x - state.x, next->gradient - state.gradient, 0.0};
        const double sy = pair.s.dot(pair.y);
        if (sy > kCurvature * pair.s.norm() * pair.y.norm()) {
            pair.per_sy = 1.0 / sy;
            kept.push_back(std::move(pair));
            if (kept.size() > kKept) kept.pop_front();
        }
        state = std::move(*next);
    }
    return {};
}

/// From the last rest, by the linear body's step; by halves where that finds none.
bool Indentation::go_to(const Vector3d& d, int halvings) {
    State begin;
    begin.x = rest_.x + x_ * (stiffness_ * (d - d_));
    if (std::optional<State> rest = find_rest(std::move(begin), d)) {
        rest_ = std::move(*rest);
        d_ = d;
        return true;
    }
    return halvings > 0 && go_to(0.5 * (d_ + d), halvings - 1) && go_to(d, halvings - 1);
}

std::optional<Vector3d> Indentation::force_n(const Vector3d& d) {
    if (!go_to(d, kHalvings)) return {};
    return rest_.finger_n;
}

}  // namespace haptable
