// SPDX-License-Identifier: GPL-2.0-or-later
// A body whose dents stiffen: the linear servo's contact with another force, that of an energy.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/bodies.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Four times the stiffness where the dent stores e_0; a tangent of 12.
constexpr StiffeningCurve kCurve{{0.5, -0.5, 3.0}, 2e-4};

/// Of a force, beside its roundings: s is 5e-6 of itself off, and Psi' goes by its cube at the most.
constexpr double kRoot = 1.5e-5;

/// Over the top of the cube and in it.
Wander on_top(unsigned seed) { return {{0.004, 0.004, kTop_m - 0.006}, {0.026, 0.026, kTop_m + 0.001}, 1e-4, seed}; }

class Stiffening : public testing::TestWithParam<std::tuple<ForceLaw, GodObject>> {
protected:
    Stiffening() {
        laws_.force = std::get<0>(GetParam());
        laws_.god_object = std::get<1>(GetParam());
        laws_.stiffening = kCurve;
        linear_ = body_of_modes("cube", laws_.force).model(laws_.god_object);
        linear_.max_force_n = 1e3F;
    }
    haptable_model linear_;
    Tables laws_;
};

/// What a scene may name beside dents that stiffen.
struct StiffeningLaw {
    const char* name;
    void (*ask)(Tables&);
};

/// The nearest point gives energy by itself.
class LeastStiffening : public Stiffening {
protected:
    Tables with(const StiffeningLaw& law) const {
        Tables laws = laws_;
        law.ask(laws);
        return laws;
    }
};

const auto kNameOfMode = [](const auto& of) {
    return test_name(std::string(word(std::get<0>(of.param))) + " " + word(std::get<1>(of.param)));
};
INSTANTIATE_TEST_SUITE_P(Modes, Stiffening,
                         testing::Combine(testing::ValuesIn(kForces), testing::ValuesIn(every<GodObject>())),
                         kNameOfMode);
INSTANTIATE_TEST_SUITE_P(Modes, LeastStiffening,
                         testing::Combine(testing::ValuesIn(kForces), testing::Values(GodObject::kLeastEnergy)),
                         kNameOfMode);

// The contact's own forces dent the linear body to where the finger is; the user feels those times Psi'.
TEST_P(Stiffening, ContactIsTheLinearOnesAndItsForceTimesPsi) {
    WithLaws body(linear_, laws_);
    Finger soft(linear_), stiff(body.model());
    Wander way = on_top(5);
    double most = 0.0;
    for (int tick = 0; tick < 6000; ++tick) {
        const Vector3d x = way.next();
        soft.to(x);
        stiff.to(x);
        ASSERT_EQ(soft.touches(), stiff.touches());
        if (!soft.touches()) continue;
        ASSERT_EQ(soft.out().patch, stiff.out().patch);
        for (int c = 0; c < 3; ++c) {
            ASSERT_EQ(soft.out().god_object_m[c], stiff.out().god_object_m[c]);
            for (int k = 0; k < 3; ++k) ASSERT_EQ(soft.out().nodal_force_n[k][c], stiff.out().nodal_force_n[k][c]);
        }
        const double factor = kCurve.factor(soft.energy());
        // u is a difference of coordinates: an absolute error in e, and so in its root, where it is small.
        ASSERT_WITHIN((stiff.force() - factor * soft.force()).norm(), .epsilon = kRoot + 64.0 * kFloat,
                      .size = factor * soft.force().norm());
        most = std::max(most, factor);
    }
    EXPECT_EQ(most, kCurve.factor(kCurve.energy_j)) << "beyond e_0 too";
}

constexpr StiffeningLaw kLaws[] = {
    {"nothing else", [](Tables&) {}},
    {"friction", [](Tables& t) { t.static_friction = t.kinetic_friction = 0.4; }},
    {"release", [](Tables& t) { t.options.set("contact.release_slew", 0.01); }},
    {"passivity", [](Tables& t) { t.options.set("contact.passivity", true); }},
    {"relaxation",
     [](Tables& t) {
         t.relaxation = {{0.5, 0.1}};
     }},
    {"relaxation without stiffening",
     [](Tables& t) {
         t.stiffening = {};
         t.relaxation = {{0.3, 0.03}, {0.3, 0.15}};
     }},
    {"grab", [](Tables& t) { t.limits.grab = true; }},
    {"rate", [](Tables& t) { t.limits.max_force_rate_n_per_s = 20.0; }},
    {"mean", [](Tables& t) { t.limits = {.mean_force_n = 0.2, .mean_force_time_s = 1.0}; }},
    {"friction, release, relaxation, rate",
     [](Tables& t) {
         t.static_friction = t.kinetic_friction = 0.4;
         t.options.set("contact.release_slew", 0.01);
         t.relaxation = {{0.5, 0.1}};
         t.limits.max_force_rate_n_per_s = 20.0;
     }},
};

// F = -dPsi/dx: what the user does over a way is what is stored, but for the steps' squares; and with least energy the
// way may lead over the surface. Presses, goes around on it and comes back, in 5,000 ticks: at no time has the hand got
// more than it gave.
TEST_P(LeastStiffening, WithAnyLawClosedLoopsGiveNoEnergy) {
    for (const StiffeningLaw& law : kLaws) {
        if (law.name == std::string("mean")) continue;  // a clamp, which needs a force of a motor's size
        SCOPED_TRACE(law.name);
        laws_.max_force_n = 1e3;
        WithLaws body(linear_, with(law));
        Finger finger(body.model());
        std::mt19937 random(13);
        std::uniform_real_distribution<double> side(0.008, 0.022), depth(0.001, 0.003);
        for (int loop = 0; loop < 3; ++loop) {
            const Vector3d above(0.015, 0.015, kTop_m + 1e-4);
            std::vector<Vector3d> corner{above, {0.015, 0.015, kTop_m - 0.002}};
            for (int k = 0; k < 2; ++k) corner.push_back({side(random), side(random), kTop_m - depth(random)});
            corner.push_back(above);
            finger.begin();
            const Work work = walk(finger, corner, 1250);
            EXPECT_GT(work.put_in_j, law.ask == kLaws[0].ask ? 0.25 * kCurve.energy_j : 0.0)
                << "deep enough to stiffen";
            EXPECT_LE(work.most_j, 1e-3 * work.put_in_j);
        }
    }
}

// Of the force, of its rise in a tick where that is limited, and of its mean.
TEST_P(LeastStiffening, WithAnyLawClampsHold) {
    constexpr double kMost_n = 0.3;
    linear_.max_force_n = static_cast<float>(kMost_n);
    laws_.max_force_n = kMost_n;
    for (const StiffeningLaw& law : kLaws) {
        SCOPED_TRACE(law.name);
        WithLaws body(linear_, with(law));
        const haptable_model& model = body.model();
        Finger finger(model);
        Wander way = on_top(17);
        double last_n = 0.0, mean2 = 0.0, largest_n = 0.0;
        for (int tick = 0; tick < 6000; ++tick) {
            finger.to(way.next());
            const double force_n = finger.force().norm();
            ASSERT_LE(force_n, kMost_n * (1.0 + 8.0 * kFloat)) << tick;
            if (model.rate != nullptr) {
                ASSERT_WITHIN(force_n - last_n - double(model.rate_n), .count = 32, .epsilon = kFloat, .size = force_n);
            }
            mean2 += 1e-3 * (force_n * force_n - mean2);
            if (model.mean != nullptr) {
                ASSERT_LE(mean2, 1.01 * double(model.mean_limit_n2)) << tick;
            }
            largest_n = std::max(largest_n, force_n);
            last_n = force_n;
        }
        EXPECT_GT(largest_n, 0.5 * kMost_n);
    }
}

// A force that grows by the tangent, not by |F| / |u|, is no jump, which a release would hold back.
TEST(StiffeningForce, IsNoJumpForARelease) {
    Tables laws;
    laws.stiffening = {{0.0, 0.0, 30.0}, 2e-3};
    laws.options.set("contact.release_slew", 1e-4);
    Press body(laws);
    for (int k = 1; k <= 50; ++k) body.to(5e-5 * k);
    EXPECT_EQ(body.finger().counters().jumps, 0U);
    EXPECT_WITHIN(body.force().z() - body.elastic_n(), .epsilon = kRoot + 64.0 * kFloat, .size = body.elastic_n());
}

// Fung's quasi-linear viscoelasticity: a ramp's elastic force, convolved with g(t); and as friction and a hand have it.
TEST(StiffeningForce, RelaxesAsTheElasticForceDoes) {
    for (const bool is_held : {false, true}) {
        Tables laws;
        laws.stiffening = kCurve;
        laws.relaxation = {{0.5, 0.1}};
        if (is_held) laws.static_friction = laws.kinetic_friction = 1e-3;
        const TickRelaxation tick = relaxation_of_tick(laws.relaxation[0]);
        Press body(laws);
        double branch = 0.0, last = 0.0;
        for (int k = 1; k <= 600; ++k) {
            body.to(1e-5 * std::min(k, 150));
            const double elastic = body.elastic_n();
            branch = branch * (1.0 - tick.fall) + tick.rise * (elastic - last);
            last = elastic;
            // The state sums 600 steps with their roundings kept.
            EXPECT_WITHIN(std::abs(body.force().z() - (0.5 * elastic + 0.5 * branch)), .epsilon = kRoot + 64.0 * kFloat,
                          .size = elastic)
                << is_held << " " << k;
        }
        EXPECT_LT(body.force().z(), 0.51 * last) << "half is left";
    }
}

}  // namespace
}  // namespace haptable::test
