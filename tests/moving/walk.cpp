// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/moving/walk.hpp"

namespace haptable::test {

using Eigen::Vector3d;

namespace {
constexpr double kBehind = 50.0;  // ticks, by which hands are behind a free body
}

Walk::Walk(const MovingTables& tables, MovingSession& session, const Touching& touching, std::mt19937& random)
    : tables_(tables), session_(session), touching_(touching), random_(random) {
    if (tables.is_free() && part() < 0.5) {
        const auto any = [&](double most) {
            return Vector3d(most * Vector3d(2 * part() - 1, 2 * part() - 1, 2 * part() - 1));
        };
        const Vector3d velocity = any(0.1);
        session.put_motion(velocity, any(5.0));
    }
    for (int h = 0; h < touching.fingers; ++h) {
        Hand& hand = hand_[std::size_t(h)];
        hand.mass_kg = 0.05;
        hand.stiffness = 60.0;
        hand.damp(tables.stiffness_limit_n_per_m());
        want(h);
        hand.at_m = hand.wants_m + 0.25 * tables.size_m() * (hand.wants_m - session.to_world({0, 0, 0})).normalized();
    }
    wanted_j_ = hands_j();
}

Vector3d Walk::point_of(std::size_t patch, double above_m) const {
    const auto corner = [&](std::size_t c) {
        const auto& x = tables_.servo().vertex_m[tables_.servo().patch[patch][c]];
        return Vector3d(double(x[0]), double(x[1]), double(x[2]));
    };
    const Vector3d a = corner(0), b = corner(1), c = corner(2);
    return (a + b + c) / 3.0 + above_m * (b - a).cross(c - a).normalized();
}

void Walk::wish(int hand, const Vector3d& world_m) {
    Hand& one = hand_[std::size_t(hand)];
    const double before_j = one.energy();
    one.wants_m = world_m;
    wanted_j_ += one.energy() - before_j;
}

// Pressed in, or off the surface, near the point that the other hand does not have.
void Walk::want(int hand) {
    const std::size_t patches = tables_.servo().patch.size();
    std::size_t patch = std::min(patches - 1, std::size_t(part() * double(patches)));
    if (hand == 1 && part() < 0.7) {  // opposite to the first
        const Vector3d other = session_.to_body(hand_[0].wants_m);
        const Vector3d middle = tables_.is_free() ? tables_.rigid().centre_m : Vector3d(Vector3d::Zero());
        const Vector3d there = 2.0 * middle - other;
        for (std::size_t p = 0; p < patches; ++p)
            if ((point_of(p, 0.0) - there).norm() < (point_of(patch, 0.0) - there).norm()) patch = p;
    }
    const double above_m = tables_.size_m() * (part() < 0.8 ? -0.12 * part() : 0.1 * part());
    point_m_[std::size_t(hand)] = point_of(patch, above_m);
    wish(hand, session_.to_world(point_m_[std::size_t(hand)]));
    left_[std::size_t(hand)] = 40 + int(120.0 * part());
}

std::array<Vector3d, 2> Walk::next() {
    for (int h = 0; h < touching_.fingers; ++h) {
        const auto i = std::size_t(h);
        if (has_begun_) hand_[i].move(session_.felt(h).force_n);
        if (--left_[i] < 0)
            want(h);
        else if (tables_.is_free())
            wish(h, hand_[i].wants_m + (session_.to_world(point_m_[i]) - hand_[i].wants_m) / kBehind);
    }
    has_begun_ = true;
    return {hand_[0].at_m, hand_[1].at_m};
}

double Walk::hands_j() const {
    double energy = 0.0;
    for (int h = 0; h < touching_.fingers; ++h) energy += hand_[std::size_t(h)].energy();
    return energy;
}

}  // namespace haptable::test
