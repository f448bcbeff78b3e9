// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/moving/walk.hpp"

namespace haptable::test {

using Eigen::Vector3d;

namespace {
constexpr double kBehind = 50.0;  // ticks, by which hands are behind a free body
}

Vector3d Surface::any_direction() {
    std::normal_distribution<double> normal;
    return Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
}

Vector3d Surface::any_point(std::size_t patch) {
    double a = part(), b = part();
    if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
    return at(patch, {1.0 - a - b, a, b});
}

Vector3d Surface::normal(std::size_t patch) const {
    const Vector3d a = corner(patch, 0);
    return (corner(patch, 1) - a).cross(corner(patch, 2) - a).normalized();
}

double Surface::shortest_edge_m() const {
    double shortest = HUGE_VAL;
    for (std::size_t p = 0; p < patches(); ++p) shortest = std::min(shortest, (corner(p, 1) - corner(p, 0)).norm());
    return shortest;
}

Walk::Walk(const MovingTables& tables, MovingSession& session, const Touching& touching, std::mt19937& random)
    : tables_(tables), session_(session), fingers_(std::size_t(touching.fingers)), surface_(tables, random) {
    if (tables.is_free() && surface_.part() < 0.5) {
        const auto any = [&](double most) {
            return Vector3d(most * Vector3d::NullaryExpr([&] { return 2.0 * surface_.part() - 1.0; }));
        };
        const Vector3d velocity = any(0.1);
        session.put_motion(velocity, any(5.0));
    }
    for (std::size_t h = 0; h < fingers_; ++h) {
        Hand& hand = hand_[h];
        hand.mass_kg = 0.05;
        hand.damp(tables.stiffness_n_per_m());
        want(h);
        hand.at_m = hand.wants_m + 0.25 * tables.size_m() * (hand.wants_m - session.to_world({0, 0, 0})).normalized();
    }
}

// Pressed in, or off the surface, near the point that the other hand does not have.
void Walk::want(std::size_t hand) {
    std::size_t patch = surface_.any_patch();
    if (hand == 1 && surface_.part() < 0.7) {  // opposite to the first
        const Vector3d there = 2.0 * tables_.rigid().centre_m - session_.to_body(hand_[0].wants_m);
        for (std::size_t p = 0; p < surface_.patches(); ++p)
            if ((surface_.middle(p) - there).norm() < (surface_.middle(patch) - there).norm()) patch = p;
    }
    const double above_m = tables_.size_m() * (surface_.part() < 0.8 ? -0.12 * surface_.part() : 0.1 * surface_.part());
    point_m_[hand] = surface_.middle(patch) + above_m * surface_.normal(patch);
    hand_[hand].wants_m = session_.to_world(point_m_[hand]);
    left_[hand] = 40 + int(120.0 * surface_.part());
}

TwoPoints Walk::next() {
    for (std::size_t h = 0; h < fingers_; ++h) {
        Hand& hand = hand_[h];
        if (has_begun_) hand.move(session_.felt(int(h)).force_n);
        if (--left_[h] < 0)
            want(h);
        else if (tables_.is_free())
            hand.wants_m += (session_.to_world(point_m_[h]) - hand.wants_m) / kBehind;
    }
    has_begun_ = true;
    return {hand_[0].at_m, hand_[1].at_m};
}

}  // namespace haptable::test
