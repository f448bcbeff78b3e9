// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/motion.hpp"

#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d symmetric(const float a[6]) {
    const auto at = [a](int i) { return static_cast<double>(a[i]); };
    Matrix3d full;
    full << at(0), at(3), at(5), at(3), at(1), at(4), at(5), at(4), at(2);
    return full;
}

}  // namespace

Rigid rigid_of(const haptable_body& body) {
    return {static_cast<double>(body.mass_kg), to_vector(body.centre_m), symmetric(body.inertia_kg_m2)};
}

Motion motion_of(const haptable_body_state& state, const Rigid& rigid) {
    const auto turn = [&](int i) { return static_cast<double>(state.turn[i]); };
    Motion m;
    m.centre_m = to_vector(state.position_m) - to_vector(state.position_low_m);
    m.turn = Eigen::Quaterniond(turn(0), turn(1), turn(2), turn(3)).normalized();
    m.momentum = rigid.mass_kg * (to_vector(state.velocity_m_per_s) - to_vector(state.velocity_low_m_per_s));
    m.spin_momentum = to_vector(state.momentum_n_m_s) - to_vector(state.momentum_low_n_m_s);
    return m;
}

Felt felt_of(const SceneState& scene, std::size_t finger, const haptable_input& in, const haptable_output& out) {
    Felt felt;
    felt.touches = haptable_touches(out.state) != 0;
    felt.at_m = to_vector(in.finger_m);
    felt.force_n = to_vector(out.force_n);
    felt.god_m = to_vector(out.god_object_m);
    felt.inside_m = to_vector(scene.servo(finger).finger_m);
    for (const float* nodal : out.nodal_force_n) felt.load_n += to_vector(nodal);
    return felt;
}

double modes_j(const SceneState& scene) {
    if (scene.modes() == nullptr) return 0.0;
    double twice = 0.0;
    for (int k = 0; k < int{scene.scene().modes->count}; ++k) {
        const haptable_modes_state& s = *scene.modes();
        const double q = static_cast<double>(s.q[k]) - static_cast<double>(s.q_low[k]);
        const double p = static_cast<double>(s.p[k]) - static_cast<double>(s.p_low[k]);
        twice += p * p + static_cast<double>(scene.scene().modes->mode[k].stiffness) * q * q;
    }
    return 0.5 * twice;
}

void Ledger::note(const Felt felt[], std::size_t fingers, double stored_j, const Motion& before, const Motion& after,
                  const Matrix6d& together) {
    bool touches = false;
    double least_j = stored_j, most_j = stored_j, alone_j = 0.0;
    Eigen::Matrix<double, 6, 2> ways = Eigen::Matrix<double, 6, 2>::Zero();  // in the world, in the body's frame
    if (rigid_ != nullptr) {
        const auto [low, high] = motion_of(before, after);
        least_j += low;
        most_j += high;
    }
    for (std::size_t f = 0; f < fingers; ++f) {
        const Vector3d inside = is_relative_ ? felt[f].inside_m
                                : rigid_ != nullptr
                                    ? Vector3d(before.turn.conjugate() * (felt[f].at_m - before.centre_m))
                                    : felt[f].at_m;
        if (ticks_ > 0) {
            const Vector3d way = felt[f].at_m - last_[f].at_m;
            given_j_ += (last_[f].force_n - last_[f].released_n).dot(way) + felt[f].released_n.dot(way);
            ways.block<3, 2>(3 * static_cast<Eigen::Index>(f), 0) << before.turn.conjugate() * way, inside - inside_[f];
            if (felt[f].touches || last_[f].touches)
                alone_j += 0.5 * stiffness_n_per_m_ * std::max(way.squaredNorm(), (inside - inside_[f]).squaredNorm());
        }
        rounded_j_ += 0x1p-24 * felt[f].load_n.norm() * (felt[f].at_m.norm() + felt[f].god_m.norm());
        touches |= felt[f].touches;
        last_[f] = felt[f];
        inside_[f] = inside;
    }
    const auto wall_of = [&](const Matrix6d& k) { return 0.5 * (ways.transpose() * k * ways).diagonal().maxCoeff(); };
    wall_j_ += std::max({alone_j, wall_of(together_), wall_of(together)});
    together_ = together;
    const double now = least_j + given_j_ - wall_j_;
    largest_j_ = std::max(largest_j_, most_j);
    if (ticks_++ > 0) risen_j_ = std::max(risen_j_, now - lowest_);
    if (!touches) lowest_ = std::min(lowest_, most_j + given_j_ - wall_j_);
}

/// A force that is held for a tick changes the momentum within it: energy of motion at the contact's moment is that
/// before, after, or the product of both (the leapfrog's), whichever is least; and most.
std::array<double, 2> Ledger::motion_of(const Motion& before, const Motion& after) const {
    const auto half = [&](const Motion& a, const Motion& b) {
        const Vector3d left = before.turn.conjugate() * a.spin_momentum,
                       right = before.turn.conjugate() * b.spin_momentum;
        return 0.5 *
               (a.momentum.dot(b.momentum) / rigid_->mass_kg + left.dot(rigid_->inertia_kg_m2.ldlt().solve(right)));
    };
    const auto [low, high] = std::minmax({half(before, before), half(before, after), half(after, after)});
    return {low, high};
}

}  // namespace haptable
