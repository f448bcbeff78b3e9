// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers on held bodies, moved as no hand would: where they are on the surface, what they feel when they are
// swapped, and what they get around closed loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/bodies.hpp"
#include "tests/moving/bodies.hpp"
#include "tests/moving/walk.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kBodies = 9;

const Shaped& body_of(std::size_t body) {
    static const std::array<Shaped, kBodies> shaped{block(), plate(), rod(),        ball(), ring(),
                                                    lump(),  slab(),  noisy_scan(), sheet()};
    return shaped[body];
}

/// Fingers that jump from patch to patch, tremble over edges, press side by side and leave one another behind.
class Adversary {
public:
    Adversary(const MovingTables& tables, std::mt19937& random)
        : surface_(tables, random), size_m_(tables.size_m()), edge_m_(surface_.shortest_edge_m()) {
        for (std::size_t f = 0; f < 2; ++f) begin(f);
    }
    TwoPoints next() {
        for (std::size_t f = 0; f < 2; ++f) {
            if (--left_[f] < 0) want(f);
            at_[f] += step_[f];
            if (trembles_[f]) at_[f] += 0.02 * edge_m_ * surface_.part() * surface_.any_direction();
        }
        return at_;
    }

private:
    void begin(std::size_t f) {
        const std::size_t patch = surface_.any_patch();
        at_[f] = surface_.any_point(patch) + 0.05 * size_m_ * surface_.normal(patch);
        step_[f].setZero();
    }
    void want(std::size_t f) {
        left_[f] = 2 + int(60.0 * surface_.part() * surface_.part());
        const std::size_t patch = surface_.any_patch();
        Vector3d to = surface_.any_point(patch);
        const double kind = surface_.part();
        if (kind < 0.55)
            to = at_[1 - f] + edge_m_ * 2.0 * surface_.part() * surface_.any_direction();
        else if (kind < 0.8)
            to = at_[f] + edge_m_ * 3.0 * surface_.part() * surface_.any_direction();
        else
            to += (0.03 - 0.12 * surface_.part()) * size_m_ * surface_.normal(patch);
        trembles_[f] = surface_.part() < 0.3;
        step_[f] = (to - at_[f]) / (left_[f] + 1);
        if (step_[f].norm() > 0.002) step_[f] *= 0.002 / step_[f].norm();
        if (surface_.part() < 0.02) begin(f);
    }

    Surface surface_;
    double size_m_, edge_m_;
    TwoPoints at_{}, step_{};
    std::array<int, 2> left_{0, 0};
    std::array<bool, 2> trembles_{false, false};
};

class TwoOnABody : public testing::TestWithParam<std::size_t> {
protected:
    /// With each force; test: of the tables, its random numbers begin with the force.
    template <typename Test>
    void with_each_force(const Test& test) const {
        for (const ForceLaw force : kForces) {
            SCOPED_TRACE(word(force));
            test(MovingTables(scene_of(body_of(GetParam()), false, 0, force, 2)), unsigned(force));
        }
    }
};

// HAPTABLE_TICKS=... of each body, force, god-object, with friction and without.
TEST_P(TwoOnABody, GodObjectsAreOnTheSurfaceInEveryTick) {
    const int ticks = asked("HAPTABLE_TICKS", 2000);
    long touched = 0, all = 0;
    with_each_force([&](const MovingTables& tables, unsigned force) {
        for (unsigned kind = 0; kind < 4; ++kind) {
            std::mt19937 random(1 + kind + 10 * force);
            const Surface surface(tables, random);
            MovingSession session(tables, {.fingers = 2,
                                           .god_object = kind / 2 == 0 ? GodObject::kLeastEnergy : GodObject::kNearest,
                                           .friction = kind % 2 == 0 ? 0.0 : 0.5});
            Adversary adversary(tables, random);
            for (int tick = 0; tick < ticks; ++tick) {
                session.step(adversary.next());
                for (int f = 0; f < 2; ++f) {
                    SCOPED_TRACE(testing::Message() << "kind " << kind << " tick " << tick << " finger " << f);
                    const Felt& felt = session.felt(f);
                    ASSERT_TRUE(session.is_sound(f));
                    ++all;
                    if (!felt.touches) continue;
                    ++touched;
                    const Vector3d alpha = to_vector(session.out(f).alpha);
                    const std::size_t patch = session.out(f).patch;
                    ASSERT_WITHIN(std::abs(alpha.sum() - 1.0), .count = 4, .epsilon = kFloat)
                        << alpha.transpose() << " of patch " << patch;
                    ASSERT_WITHIN((surface.at(patch, alpha) - felt.god_m).norm(), .count = 8, .epsilon = kFloat,
                                  .size = 0.1);
                    ASSERT_GE(alpha.minCoeff(), 0.0);
                    ASSERT_LE(alpha.maxCoeff(), 1.0);
                }
            }
        }
    });
    EXPECT_GT(touched, all / 10);
}

// C is symmetric, and so is all that two nearest god-objects feel: to the rounding of a solve for six unknowns, of
// which at least a 64th is definite. On the slab two fingers come to load one node alone, next to fixed ones, where
// which of them touches is not to hang on rounding.
TEST_P(TwoOnABody, SwappedFingersFeelSwappedForces) {
    const int ticks = asked("HAPTABLE_TICKS", body_of(GetParam()).name == "slab" ? 50000 : 2000);
    int both = 0;
    with_each_force([&](const MovingTables& tables, unsigned force) {
        std::mt19937 random(100 + force);
        const Touching touching{.fingers = 2, .god_object = GodObject::kNearest};
        MovingSession session(tables, touching), swapped(tables, touching);
        Adversary adversary(tables, random);
        for (int tick = 0; tick < ticks; ++tick) {
            const TwoPoints at = adversary.next();
            session.step(at);
            swapped.step({at[1], at[0]});
            double size_n = 0.0;  // of a solve the larger of the two sides, as the stiffness has it
            for (int f = 0; f < 2; ++f) {
                const Felt& felt = session.felt(f);
                const double dent_m = felt.touches ? (felt.inside_m - felt.god_m).norm() : 0.0;
                size_n += std::max(tables.stiffness_n_per_m() * dent_m, felt.force_n.norm());
            }
            for (int f = 0; f < 2; ++f) {
                const Felt &felt = session.felt(f), &other = swapped.felt(1 - f);
                ASSERT_EQ(felt.god_m, other.god_m) << "tick " << tick;
                ASSERT_WITHIN((felt.force_n - other.force_n).norm(), .count = 16, .epsilon = kFloat, .condition = 64.0,
                              .size = size_n)
                    << "tick " << tick << " finger " << f << ": " << felt.force_n.transpose() << " and "
                    << other.force_n.transpose();
            }
            both += session.felt(0).force_n.norm() > 0.0 && session.felt(1).force_n.norm() > 0.0;
        }
    });
    EXPECT_GT(both, ticks / 4);
}

/// A finger's closed path: it waits, goes in, aside and out, and comes home outside.
struct Loop {
    Vector3d home, normal, aside;
    double deep_m = 0.0;
    int wait = 0, in = 0, along = 0, stay = 0;
    int ticks() const { return wait + 3 * in + 2 * along + stay; }
    Vector3d at(int tick) const {
        const auto part = [&tick](int length) {
            const double done = std::clamp(double(tick) / length, 0.0, 1.0);
            tick -= length;
            return done;
        };
        tick -= wait;
        const double in1 = part(in), along1 = part(along);
        tick -= stay;
        const double out = part(2 * in), back = part(along);
        return home + (out - in1) * deep_m * normal + (along1 - back) * aside;
    }
};

Loop any_loop(Surface& surface, double size_m) {
    constexpr double kSlow_m = 1e-5;  // a tick
    Loop loop;
    const std::size_t patch = surface.any_patch();
    loop.normal = surface.normal(patch);
    loop.home = surface.any_point(patch) + 1e-4 * loop.normal;
    loop.deep_m = 1e-4 + (0.01 + 0.06 * surface.part()) * size_m;
    loop.aside = (0.1 * size_m * surface.part()) * loop.normal.cross(surface.any_direction()).normalized();
    loop.wait = int(300 * surface.part());
    loop.stay = int(300 * surface.part());
    loop.in = 1 + int(loop.deep_m / kSlow_m);
    loop.along = 1 + int(loop.aside.norm() / kSlow_m);
    return loop;
}

// HAPTABLE_LOOPS=... of each body and force. Nor does a force step where a finger meets the surface that the other has
// moved: by no more than twice the stiffness times the ways of the tick.
TEST_P(TwoOnABody, ClosedLoopsGiveNoEnergy) {
    const int loops = asked("HAPTABLE_LOOPS", 6);
    int met = 0;
    with_each_force([&](const MovingTables& tables, unsigned force) {
        for (int number = 0; number < loops; ++number) {
            std::mt19937 random(unsigned(number) + 1000 * force);
            Surface surface(tables, random);
            const Loop one = any_loop(surface, tables.size_m()), two = any_loop(surface, tables.size_m());
            MovingSession session(tables, {.fingers = 2});
            Round round;
            const int ticks = std::max(one.ticks(), two.ticks()) + 1;
            for (int tick = 0; tick <= ticks; ++tick) {
                const bool both_touched = tick > 0 && session.both_touch();
                const bool one_touched = session.touches() && !both_touched;
                session.step({one.at(tick), two.at(tick)});
                round.add(session);
                if (!one_touched || !session.both_touch()) continue;
                ++met;
                EXPECT_LE(round.step_n(), 2.0 * tables.stiffness_n_per_m() * round.way_m())
                    << "loop " << number << ", tick " << tick;
            }
            if (!(round.paid_j() > 1e-9) || session.touches()) continue;  // home is within another part
            EXPECT_LE(round.given_j(), 1e-3 * round.paid_j()) << "loop " << number;
        }
    });
    EXPECT_GT(met, 0);
}

std::string name_of_body(const testing::TestParamInfo<std::size_t>& info) { return body_of(info.param).name; }
INSTANTIATE_TEST_SUITE_P(Bodies, TwoOnABody, testing::Range<std::size_t>(0, kBodies), name_of_body);

}  // namespace
}  // namespace haptable::test
