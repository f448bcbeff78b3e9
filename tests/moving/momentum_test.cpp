// SPDX-License-Identifier: GPL-2.0-or-later
// Action is reaction: in every tick the momentum of a free body, linear and angular, changes by what the hands, its
// weight, the floor and its suspension gave, to 16 roundings, and by nothing else (Newton's second and third law).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "tests/moving/bodies.hpp"
#include "tests/moving/walk.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.81;

/// By how much a tick's change of momentum misses what acted on the body: over its bound, which is 16 roundings; or
/// beyond what a floor can give.
struct Missed {
    double linear = 0.0, angular = 0.0, floor = 0.0;
    double largest() const { return std::max({linear, angular, floor}); }
    void take(const Missed& other) {
        linear = std::max(linear, other.linear);
        angular = std::max(angular, other.angular);
        floor = std::max(floor, other.floor);
    }
    std::string says() const {
        return fmt::format("linear {}, angular {}, floor {} times 16 roundings", linear, angular, floor);
    }
};

/// The bound of the law, in kg m/s or kg m^2/s.
double roundings(double size) { return Bound{.count = 16, .epsilon = kFloat, .size = size}.value(); }

/// What acted on the body from outside in a tick, N s and N m s about the centre, and of what size rounding is.
struct Given {
    Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
    double linear_size = 0.0, angular_size = 0.0;
    double angular_slack = 0.0;  ///< a moment that changes in the tick may act as it was at any time of it

    void add(const Vector3d& impulse, const Vector3d& arm, double arm_size) {
        linear += impulse;
        linear_size += impulse.norm();
        angular += arm.cross(impulse);
        angular_size += arm_size * impulse.norm();
    }
};

class MomentumLaw {
public:
    MomentumLaw(const MovingTables& tables, const Touching& touching) : rigid_(tables.rigid()), touching_(touching) {
        const haptable_body& body = *tables.loaded().body();
        for (std::uint32_t i = 0; i < body.point_count; ++i) floor_point_m_.push_back(to_vector(body.point_m[i]));
        for (const Vector3d& x : floor_point_m_) longest_m_ = std::max(longest_m_, (x - rigid_.centre_m).norm());
    }

    /// One tick: where the body was before and after it, and what each finger was given.
    Missed judge(const MovingSession& session, const Motion& before, const Motion& after) {
        Given given;
        for (int f = 0; f < touching_.fingers; ++f) {
            const Felt& felt = session.felt(f);
            const Vector3d arm = felt.at_m - before.centre_m;
            given.add(-kTick_s * felt.force_n, arm, felt.at_m.norm() + before.centre_m.norm() + arm.norm());
        }
        given.add(kTick_s * rigid_.mass_kg * touching_.gravity_m_per_s2, Vector3d::Zero(), 0.0);
        hang(before, after, given);
        const Vector3d linear = after.momentum - before.momentum - given.linear;
        const Vector3d angular = after.spin_momentum - before.spin_momentum - given.angular;
        given.linear_size += before.momentum.norm() + after.momentum.norm();
        given.angular_size += before.spin_momentum.norm() + after.spin_momentum.norm();
        Missed missed;
        if (is_near_floor(before) || is_near_floor(after)) {
            missed.floor = beyond_floor(linear, angular, given, before.turn.angularDistance(after.turn));
        } else {
            missed.linear = linear.norm() / roundings(given.linear_size);
            missed.angular = std::max(0.0, angular.norm() - given.angular_slack) / roundings(given.angular_size);
            carried_ = 0.0;
        }
        return missed;
    }

private:
    /// A suspension keeps the energy of a tick: its springs act as in the mean of both ends, its dampers by the way.
    void hang(const Motion& before, const Motion& after, Given& given) const {
        const Vector3d way = after.centre_m - before.centre_m,
                       middle = 0.5 * (after.centre_m + before.centre_m) - rigid_.centre_m;
        given.add(-touching_.hang_n_per_m * kTick_s * middle - touching_.hang_n_s_per_m * way, Vector3d::Zero(), 0.0);
        given.linear_size += touching_.hang_n_per_m * kTick_s * rigid_.centre_m.norm();
        // What the hands gave came first: the damper feels it.
        Motion kicked = before;
        kicked.spin_momentum += given.angular;
        const Vector3d first = moment(kicked), last = moment(after);
        given.angular_slack += kTick_s * ((first - last).norm() + (moment(before) - first).norm());
        given.angular += 0.5 * kTick_s * (first + last);
        given.angular_size += kTick_s * (first.norm() + touching_.twist_n_m);
    }
    /// Of a suspension with the energy 2 sum k q_i^2, and its damper; world axes.
    Vector3d moment(const Motion& m) const {
        const Vector3d v = m.turn.vec();
        const Vector3d spin = rigid_.inertia_kg_m2.ldlt().solve(m.turn.conjugate() * m.spin_momentum);
        return m.turn * Vector3d(-2.0 * touching_.twist_n_m * m.turn.w() * v - touching_.twist_n_m_s * spin);
    }

    bool is_near_floor(const Motion& m) const {
        return touching_.floor && lowest_m(m) < lowest_m({.centre_m = rigid_.centre_m}) + 1e-6;
    }
    double lowest_m(const Motion& m) const {
        double lowest = HUGE_VAL;
        for (const Vector3d& x : floor_point_m_)
            lowest = std::min(lowest, (m.centre_m + m.turn * (x - rigid_.centre_m)).z());
        return lowest;
    }

    /// What is left of a change of momentum is the floor's: up; along it within Coulomb's cone, of what carried the
    /// body in this tick or the last; its moment that of forces at points of the body, which turn within the tick. A
    /// point that lands or slips otherwise than was tried may miss that, by a tenth of the weight and half of the cone;
    /// without friction there is nothing along the floor.
    double beyond_floor(const Vector3d& linear, const Vector3d& angular, const Given& given, double turned) {
        const double up = linear.z(), most = std::max(up, carried_), mu = 1.5 * touching_.floor_friction;
        const double tried = 0.1 * kGravity * kTick_s * rigid_.mass_kg;
        const double moment = longest_m_ * ((1.0 + mu) * most + tried);
        carried_ = std::max(up, 0.0);
        const double linear_slack = roundings(given.linear_size + most);
        const double angular_slack = roundings(given.angular_size + moment) + given.angular_slack + turned * moment;
        return std::max({(-up - tried) / linear_slack, (linear.head<2>().norm() - mu * most) / linear_slack,
                         (angular.norm() - moment) / angular_slack,
                         (std::abs(angular.z()) - longest_m_ * mu * most) / angular_slack});
    }

    const Rigid& rigid_;
    std::vector<Vector3d> floor_point_m_;  ///< what may rest on the floor
    Touching touching_;
    double longest_m_ = 0.0, carried_ = 0.0;
};

constexpr std::size_t kTables = 12;

/// Six shapes, stiff and ringing, each with one of the forces.
std::unique_ptr<MovingTables> tables_of(std::size_t number) {
    static const std::array<Shaped, 6> shaped{block(), plate(), rod(), ball(), ring(), lump()};
    const std::size_t shape = number % shaped.size(), rings = number / shaped.size();
    const ForceLaw force = every<ForceLaw>()[(shape + rings) % 3];
    return std::make_unique<MovingTables>(scene_of(shaped[shape], true, rings == 0 ? 0 : 8, force, 2));
}

Touching any_touching(std::mt19937& random) {
    std::uniform_int_distribution<int> coin(0, 1), three(0, 2), five(0, 4);
    Touching touching;
    touching.fingers = 1 + coin(random);
    touching.god_object = coin(random) == 0 ? GodObject::kNearest : GodObject::kLeastEnergy;
    touching.friction = coin(random) == 0 ? 0.0 : 0.8;
    if (five(random) == 0) touching.max_force_n = 0.2;  // what is cut for the hand is cut for the body
    switch (three(random)) {
        case 0:
            touching.gravity_m_per_s2 = {0.0, 0.0, -kGravity};
            touching.floor = true;
            touching.floor_friction = 0.0;
            break;
        case 1:
            touching.hang_n_per_m = 20.0;
            touching.twist_n_m = 2e-3;
            if (coin(random) == 0) break;
            touching.hang_n_s_per_m = 0.05;
            touching.twist_n_m_s = 1e-5;
            break;
        default:
            if (coin(random) == 0) touching.gravity_m_per_s2 = {1.0, 2.0, -kGravity};
    }
    return touching;
}

// HAPTABLE_SESSIONS=1000 HAPTABLE_TICKS=... judges as many.
TEST(Momentum, ChangesByWhatActsOnTheBody) {
    const int sessions = asked("HAPTABLE_SESSIONS", 1000), ticks = asked("HAPTABLE_TICKS", 300);
    std::array<std::unique_ptr<MovingTables>, kTables> made;
    int contact_ticks = 0, both_ticks = 0, floor_ticks = 0, broken_sessions = 0;
    Missed worst;
    for (int number = 0; number < sessions; ++number) {
        std::mt19937 random(static_cast<unsigned>(number));
        auto& tables = made[static_cast<std::size_t>(number) % kTables];
        if (!tables) tables = tables_of(static_cast<std::size_t>(number) % kTables);
        const Touching touching = any_touching(random);
        MovingSession session(*tables, touching);
        Walk walk(*tables, session, touching, random);
        MomentumLaw law(*tables, touching);
        Missed most;
        int first = -1;
        for (int tick = 0; tick < ticks; ++tick) {
            const Motion before = session.motion();
            session.step(walk.next());
            const Missed missed = law.judge(session, before, session.motion());
            contact_ticks += session.touches();
            both_ticks += session.both_touch();
            floor_ticks += session.is_on_floor();
            if (missed.largest() > 1.0 && first < 0) first = tick;
            most.take(missed);
        }
        worst.take(most);
        if (first < 0 || ++broken_sessions > 3) continue;
        ADD_FAILURE() << "session " << number << " on " << tables->scene().name << ", from tick " << first << ": "
                      << most.says();
    }
    EXPECT_EQ(broken_sessions, 0) << "of " << sessions << "; the worst: " << worst.says();
    // The sessions are worth something.
    EXPECT_GT(contact_ticks, sessions * ticks / 10);
    EXPECT_GT(both_ticks, sessions * ticks / 50);
    EXPECT_GT(floor_ticks, sessions * ticks / 20);
}

}  // namespace
}  // namespace haptable::test
