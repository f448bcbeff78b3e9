// SPDX-License-Identifier: GPL-2.0-or-later
// An account of energy that nobody can talk into anything: of the body's motion, its modes and its contacts, and what
// the hands were given.
#pragma once

#include <algorithm>
#include <cmath>

#include "tests/moving/adapter.hpp"

namespace haptable::test {

/// What there is and what the hands were given never rises, from any moment on at which nothing touches, by more than a
/// wall of the body's stiffness makes of the same hands: k/2 times a tick's way in the body's frame, squared, while a
/// finger touches (Colgate and Schenkel 1997).
class Ledger {
public:
    Ledger(const MovingTables& tables, const Touching& touching) : tables_(tables), touching_(touching) {}

    /// One tick. before: of a free body, as it was before the step.
    void note(const MovingSession& session, const Motion& before) {
        double least_j = session.contact_j() + session.modes_j(), most_j = least_j;
        if (tables_.is_free()) {
            const auto [low, high] = motion_of(before, session.motion());
            least_j += low;
            most_j += high;
        }
        for (int f = 0; f < touching_.fingers; ++f) {
            const auto i = std::size_t(f);
            const Felt& felt = session.felt(f);
            const Eigen::Vector3d inside =
                tables_.is_free() ? Eigen::Vector3d(before.turn.conjugate() * (felt.at_m - before.centre_m))
                                  : felt.at_m;
            if (ticks_ > 0) {
                given_j_ += last_[i].force_n.dot(felt.at_m - last_[i].at_m);
                if (felt.touches || last_[i].touches) wall_j_ += wall_of(inside - inside_[i]);
            }
            rounded_j_ += kFloat_ * felt.load_n.norm() * (felt.at_m.norm() + felt.god_m.norm());
            last_[i] = felt;
            inside_[i] = inside;
        }
        const double now = least_j + given_j_ - wall_j_;
        largest_j_ = std::max(largest_j_, most_j);
        if (ticks_++ > 0) {
            if (now - lowest_ > risen_j_) risen_j_ = now - lowest_, risen_tick_ = ticks_ - 1;
        }
        if (!session.felt(0).touches && !session.felt(1).touches)
            lowest_ = std::min(lowest_, most_j + given_j_ - wall_j_);
    }

    double risen_j() const { return risen_j_; }  ///< the most, beyond what a wall makes
    int risen_tick() const { return risen_tick_; }
    double largest_j() const { return largest_j_; }  ///< that there was at once
    double wall_j() const { return wall_j_; }
    double given_j() const { return given_j_; }
    /// What float forces and places make of the work, J: a rounding of each a tick, all of one sign.
    double rounded_j() const { return rounded_j_; }

private:
    static constexpr double kFloat_ = 0x1p-24;

    double wall_of(const Eigen::Vector3d& way) const {
        return 0.5 * tables_.stiffness_limit_n_per_m() * way.squaredNorm();
    }
    /// A force that is held for a tick changes the momentum within it: energy of motion at the contact's moment is that
    /// before, after, or the product of both (the leapfrog's), whichever is least; and most.
    std::pair<double, double> motion_of(const Motion& before, const Motion& after) const {
        const Rigid& rigid = tables_.rigid();
        const auto half = [&](const Motion& a, const Motion& b) {
            const Eigen::Vector3d left = before.turn.conjugate() * a.spin_momentum,
                                  right = before.turn.conjugate() * b.spin_momentum;
            return 0.5 *
                   (a.momentum.dot(b.momentum) / rigid.mass_kg + left.dot(rigid.inertia_kg_m2.ldlt().solve(right)));
        };
        const auto [low, high] = std::minmax({half(before, before), half(before, after), half(after, after)});
        return {low + hung_j(before), high + hung_j(before)};
    }

    double hung_j(const Motion& m) const {
        return 0.5 * touching_.hang_n_per_m * (m.centre_m - tables_.rigid().centre_m).squaredNorm() +
               2.0 * touching_.twist_n_m * m.turn.vec().squaredNorm();
    }

    const MovingTables& tables_;
    Touching touching_;
    std::array<Felt, 2> last_;
    std::array<Eigen::Vector3d, 2> inside_;
    double given_j_ = 0.0, wall_j_ = 0.0, lowest_ = HUGE_VAL, risen_j_ = 0.0, largest_j_ = 0.0, rounded_j_ = 0.0;
    int ticks_ = 0, risen_tick_ = -1;
};

}  // namespace haptable::test
