// SPDX-License-Identifier: GPL-2.0-or-later
// Newton's first law and Galileo's: what nothing touches does not change, what is carried evenly needs no force, and a
// finger gives a body that it pushes at most twice its own speed.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "host/base/mass_range.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/hand.hpp"
#include "tests/moving/adapter.hpp"
#include "tests/moving/bodies.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

const Vector3d kAway = Vector3d::Constant(1.0);

struct FreeOptions {
    int fingers = 2;
    double mass_kg = 0.0;  ///< zero: by its density
    double scale = 1.0;
    int modes = 0;
};

Scene free_scene(const Shaped& shaped, const FreeOptions& options) {
    Scene scene = scene_of(shaped, true, options.modes, ForceLaw::kConsistent, options.fingers);
    scene.mesh.scale_m = options.scale;
    scene.free_body->mass_kg = options.mass_kg;
    scene.free_body->floor.reset();
    return scene;
}

/// A block of that mass by one of its sides' ends: its side, or its moments of inertia, m side^2 / 6 each.
constexpr double kSide_m = 0.03;
double side_of(double mass_kg, double inertia_kg_m2) { return std::sqrt(6.0 * inertia_kg_m2 / mass_kg); }
MovingTables block_of(double mass_kg, double side_m) {
    return MovingTables(free_scene(block(), {.mass_kg = mass_kg, .scale = side_m / kSide_m}));
}

// At the ends of what [body] mass and moments of inertia may be a body is pushed, and all that is felt and all of its
// motion are numbers.
TEST(Inertia, BodiesAtTheEndsOfTheRangeMoveAsNumbers) {
    for (const auto& [mass_kg, side_m] : {std::pair{kLeastMass_kg, kSide_m},
                                          {kMostMass_kg, kSide_m},
                                          {kLeastMass_kg, 1.001 * side_of(kLeastMass_kg, kLeastInertia_kg_m2)},
                                          {kMostMass_kg, 0.999 * side_of(kMostMass_kg, kMostInertia_kg_m2)}}) {
        SCOPED_TRACE(testing::Message() << mass_kg << " kg, " << side_m << " m");
        const MovingTables tables = block_of(mass_kg, side_m);
        MovingSession session(tables, {.fingers = 2});
        int contact_ticks = 0;
        for (int tick = 0; tick < 4000; ++tick) {
            const double deep = 0.07 * std::sin(0.004 * tick);
            session.step({side_m * Vector3d(-deep, 0.47, 0.53), side_m * Vector3d(1.0 + deep, 0.43, 0.57)});
            contact_ticks += session.touches();
            ASSERT_TRUE(session.is_sound()) << "tick " << tick;
        }
        EXPECT_GT(contact_ticks, 0);
    }
}

TEST(Inertia, BeyondItsRangeIsRefused) {
    for (const auto& [mass_kg, side_m] : {std::pair{kLeastMass_kg, 0.999 * side_of(kLeastMass_kg, kLeastInertia_kg_m2)},
                                          {kMostMass_kg, 1.001 * side_of(kMostMass_kg, kMostInertia_kg_m2)}}) {
        EXPECT_TRUE(
            fails_with([&] { block_of(mass_kg, side_m); }, "body.mass: the body's principal moments of inertia are"));
    }
}

/// The most that a motion that nobody touches comes to differ from its begin, looked at every `stride` ticks.
struct Drift {
    double linear = 0.0, turning = 0.0, energy = 0.0;
    double turning_size = 0.0, energy_size = 0.0;
    double condition = 1.0;  ///< of energy: of how the body lies, by its moments of inertia
};

Drift drift_of(const MovingTables& tables, const Vector3d& velocity, const Vector3d& spin, int ticks, int stride) {
    MovingSession session(tables, {.fingers = tables.scene().contact.fingers});
    session.put_motion(velocity, spin);
    const Motion begun = session.motion();
    const Vector3d moments = tables.rigid().inertia_kg_m2.selfadjointView<Eigen::Lower>().eigenvalues();
    const double ratio = moments.maxCoeff() / moments.minCoeff();
    Drift drift{.turning_size = begun.spin_momentum.norm(),
                .energy_size = session.motion_j(),
                .condition = 1.0 + (ratio - 1.0) / std::sqrt(ratio)};
    for (int tick = 0; tick < ticks; ++tick) {
        session.step({kAway, kAway});
        if (tick % stride != 0) continue;
        const Motion now = session.motion();
        drift.linear = std::max(drift.linear, (now.momentum - begun.momentum).norm());
        drift.turning = std::max(drift.turning, (now.spin_momentum - begun.spin_momentum).norm());
        drift.energy = std::max(drift.energy, std::abs(session.motion_j() - drift.energy_size));
    }
    return drift;
}

// An hour without a touch, at rest and in spins about a general axis: linear momentum to the last bit, angular momentum
// to 100 roundings, energy to what 100 roundings of the turn make of it (docs/design/moving.md). The rod, whose moments
// of inertia differ most, for an hour; the others, and what could ring, for six minutes, or all for HAPTABLE_SECONDS.
TEST(Inertia, NothingTouchesItNothingChanges) {
    for (const auto& [shaped, modes, seconds] :
         {std::tuple{block(), 0, 360}, {plate(), 0, 360}, {rod(), 0, 3600}, {rod(), 8, 360}}) {
        const MovingTables tables(free_scene(shaped, {.fingers = modes > 0 ? 2 : 1, .modes = modes}));
        for (const double spin : {0.0, 1.0, 10.0}) {
            SCOPED_TRACE(testing::Message() << shaped.name << ", " << modes << " modes, " << spin << " rad/s");
            const Drift drift = drift_of(tables, {0.02, -0.01, 0.005}, spin * Vector3d(2.0, -1.0, 2.0) / 3.0,
                                         1000 * asked("HAPTABLE_SECONDS", seconds), 100);
            EXPECT_EQ(drift.linear, 0.0);
            EXPECT_WITHIN(drift.turning, .count = 100, .epsilon = kFloat, .size = drift.turning_size);
            EXPECT_WITHIN(drift.energy, .count = 100, .epsilon = kFloat, .condition = drift.condition,
                          .size = drift.energy_size);
        }
    }
}

// A body of which a hand flicks a side at 1 to 3 m/s spins so fast that a tick turns it by half of a radian; a slender
// one about its own axis, where its energy hangs most on how it lies. Each tick's spin is good to some roundings, of
// which a minute has 60,000: they add up as a walk does, with room.
TEST(Inertia, FastSpinsKeepTheirEnergy) {
    constexpr int kTicks = 60000;
    for (const Shaped& shaped : {plate(), rod()}) {
        const MovingTables tables(free_scene(shaped, {.fingers = 1}));
        for (const double spin : {100.0, 400.0})
            for (const Vector3d& axis : {Vector3d(2.0, -1.0, 2.0), Vector3d(0.2, 0.1, 2.0), Vector3d(2.0, 0.3, 0.1)}) {
                const Drift drift = drift_of(tables, Vector3d::Zero(), spin * axis.normalized(), kTicks, 1);
                EXPECT_WITHIN(drift.energy, .count = 100 * std::sqrt(double(kTicks)), .epsilon = kFloat,
                              .condition = drift.condition, .size = drift.energy_size)
                    << shaped.name << " at " << spin << " rad/s about " << axis.transpose();
            }
    }
}

/// Two fingers that close on the block from its sides, and grip it 3 mm deep.
TwoPoints grip(int tick) {
    const double in = std::min(0.003, -0.001 + 2e-5 * tick);
    return {Vector3d(0.015, in, 0.014), Vector3d(0.015, 0.03 - in, 0.016)};
}
/// One that pushes, and is left behind.
TwoPoints push_slowly(int tick) { return {Vector3d(0.0153, -0.001 + 1e-4 * std::min(tick, 100), 0.0149), {}}; }

// What moves evenly with body and hands feels what is felt at rest, to the roundings of places in each tick, each a
// force: they add up, as nothing here loses energy.
TEST(Inertia, EvenMotionIsNotFelt) {
    constexpr int kTicks = 1000;
    const MovingTables tables(free_scene(block(), {}));
    for (const Vector3d& velocity : {Vector3d(0.1, 0.0, 0.0), Vector3d(0.03, -0.2, 0.06)})
        for (const Touching& touching : {Touching{}, Touching{.fingers = 2, .friction = 0.8}}) {
            MovingSession still(tables, touching), moving(tables, touching);
            moving.put_motion(velocity, Vector3d::Zero());
            double worst = 0.0, farthest = 0.0;
            int contact_ticks = 0;
            for (int tick = 0; tick < kTicks; ++tick) {
                const TwoPoints at = touching.fingers == 2 ? grip(tick) : push_slowly(tick);
                const Vector3d gone = kTick_s * tick * velocity;
                still.step(at);
                moving.step({at[0] + gone, at[1] + gone});
                contact_ticks += still.felt(0).touches;
                farthest = std::max(farthest, gone.norm() + at[0].norm());
                for (int f = 0; f < touching.fingers; ++f)
                    worst = std::max(worst, (still.felt(f).force_n - moving.felt(f).force_n).norm());
            }
            EXPECT_GT(contact_ticks, 20);
            EXPECT_WITHIN(worst, .count = 16 * std::sqrt(double(kTicks)), .epsilon = kFloat,
                          .size = tables.stiffness_n_per_m() * farthest)
                << velocity.transpose() << " m/s, " << touching.fingers << " fingers";
        }
}

// A grip that begins to move and then goes on evenly: over 2 s the mean force is what the body's momentum can have
// changed by meanwhile, as it swings between the fingers.
TEST(Inertia, CarriedEvenlyNeedsNoForce) {
    const MovingTables tables(free_scene(block(), {}));
    constexpr double kSpeed = 0.1;
    MovingSession session(tables, {.fingers = 2, .friction = 0.8});
    double along = 0.0;
    for (int tick = 0; tick < 4000; ++tick) {
        TwoPoints at = grip(tick);
        for (Vector3d& one : at) one.x() += kSpeed * kTick_s * std::max(0, tick - 1000);
        session.step(at);
        if (tick < 2000) continue;
        ASSERT_TRUE(session.both_touch()) << "tick " << tick;
        along += session.force_n().x() / 2000.0;
    }
    EXPECT_LE(std::abs(along), 2.0 * tables.rigid().mass_kg * kSpeed / 2.0);
    EXPECT_NEAR(session.motion().centre_m.x(), tables.rigid().centre_m.x() + 0.3, 0.005);
}

/// What a push through the middle came to.
struct Push {
    Vector3d given = Vector3d::Zero(), has = Vector3d::Zero();  ///< N s
    double roundings = 0.0, deepest_m = 0.0;
};

/// A finger that goes on evenly until the body has left it; in its first tick it is at that fraction of its way.
Push push(const MovingTables& tables, double speed, double fraction) {
    MovingSession session(tables, {});
    Vector3d finger(-0.001 - fraction * speed * kTick_s, 0.015, 0.015);
    Push push;
    bool has_touched = false;
    for (int tick = 0; tick < 20000 && !(has_touched && !session.touches()); ++tick) {
        finger.x() += speed * kTick_s;
        push.deepest_m = std::max(push.deepest_m, session.to_body(finger).x());
        session.step({finger, finger});
        push.given -= kTick_s * session.force_n();
        push.roundings += kTick_s * session.force_n().norm() + session.motion().momentum.norm();
        has_touched |= session.touches();
    }
    EXPECT_TRUE(has_touched);
    push.has = session.motion().momentum;
    return push;
}

// A finger that pushes a free body and is left behind gives it at most twice its own speed, which is an elastic blow by
// a wall; and the body has what the finger felt. Where in a tick the contact begins and ends makes up to k (v T)^2 / 8
// of energy, which is 1 + k T^2 / 4 m of the blow's. A force that falls is given as it is two ticks later: that leaves
// 2 T sqrt(k / m) of the finger's speed out.
TEST(Inertia, APushGivesAtMostTwiceItsSpeed) {
    int pushes = 0;
    for (const double mass : {0.0027, 0.027, 0.27}) {
        const MovingTables tables(free_scene(block(), {.fingers = 1, .mass_kg = mass}));
        const double sampled = tables.stiffness_n_per_m() * kTick_s * kTick_s / (4.0 * mass);
        const double least = std::min(1.5, 2.0 - 4.0 * std::sqrt(sampled));
        for (const double speed : {0.01, 0.03, 0.1, 0.3, 1.0})
            for (const double fraction : {0.0, 0.25, 0.5, 0.75}) {
                SCOPED_TRACE(testing::Message() << mass << " kg at " << speed << " m/s");
                const Push pushed = push(tables, speed, fraction);
                EXPECT_WITHIN((pushed.has - pushed.given).norm(), .count = 16, .epsilon = kFloat,
                              .size = pushed.roundings);
                if (pushed.deepest_m > 0.01) continue;  // a third of the block: it comes out at another side
                ++pushes;
                EXPECT_LE(pushed.has.norm() / mass, speed * (1.0 + std::sqrt(1.0 + sampled)) * (1.0 + 1e-5));
                EXPECT_GT(pushed.has.x() / mass, least * speed);
            }
    }
    EXPECT_GE(pushes, 40);
}

// A free ring that a finger enters and slides along: the nearest god-object's force has no energy, and hand and body
// get no more than one wall makes of the finger's way.
TEST(Inertia, SlowSlideOnAFreeBodyMakesNoMoreThanAWall) {
    Scene scene = read_scene("meshes/hard/torus.toml");
    set_free(scene);
    const MovingTables tables(scene);
    MovingSession session(tables, {.god_object = GodObject::kNearest});
    Ledger ledger = ledger_of(tables);
    const std::array<Vector3d, 3> entry{Vector3d(-0.018206322, 0.034019038, 0.014819929),
                                        Vector3d(-0.018212853, 0.034031853, 0.014759747),
                                        Vector3d(-0.018225914, 0.034057487, 0.014639380)};
    const Vector3d from(-0.018261803, 0.034127913, 0.014530926), step(-1.1563e-5, 2.2598e-5, 4.943e-6);
    for (int tick = 0; tick < 37; ++tick) {
        const Vector3d at = tick < 3 ? entry[std::size_t(tick)] : Vector3d(from + (tick - 3) * step);
        session.step({at, at}, ledger);
    }
    EXPECT_TRUE(session.touches());
    EXPECT_LE(made_j(ledger), 0.0);
}

}  // namespace
}  // namespace haptable::test
