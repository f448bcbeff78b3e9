// SPDX-License-Identifier: GPL-2.0-or-later
// A body whose dents stiffen: the linear servo's contact with another force, that of an energy.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "codegen/laws.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/reference_servo.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Four times the stiffness where the dent stores e_0; a tangent of 12.
constexpr StiffeningCurve kCurve{{0.5, -0.5, 3.0}, 2e-4};

/// Of a force, beside its roundings: s is 5e-6 of itself off, and Psi' goes by its cube at the most.
constexpr double kRoot = 1.5e-5;

/// A model that stiffens, with its table.
class Stiffened {
public:
    explicit Stiffened(const haptable_model& linear, const StiffeningCurve& curve = kCurve)
        : table_(stiffening_table(curve)), model_(linear) {
        model_.relax = haptable_stiffening;
        model_.stiffen = haptable_stiffened_of;
        model_.stiffening = table_.data();
    }
    Stiffened(const Stiffened&) = delete;
    Stiffened& operator=(const Stiffened&) = delete;
    haptable_model& model() { return model_; }

private:
    std::vector<float> table_;
    haptable_model model_;
};

/// A finger over the top of the cube and in it, 0.2 mm a tick at the most.
class Wander {
public:
    explicit Wander(unsigned seed) : random_(seed) { aim(); }
    Vector3d next() {
        if ((aim_ - x_).norm() < kStep_m) aim();
        return x_ += kStep_m * (aim_ - x_).normalized();
    }

private:
    static constexpr double kStep_m = 1e-4;
    void aim() {
        std::uniform_real_distribution<double> side(0.004, 0.026), depth(-0.006, 0.001);
        aim_ = {side(random_), side(random_), kTop_m + depth(random_)};
    }
    std::mt19937 random_;
    Vector3d x_{0.015, 0.015, kTop_m + 1e-3}, aim_;
};

class Stiffening : public testing::TestWithParam<std::tuple<ForceLaw, GodObject>> {
protected:
    Stiffening() : linear_(body_of_modes("cube", std::get<0>(GetParam())).model(std::get<1>(GetParam()))) {
        linear_.max_force_n = 1e3F;
    }
    haptable_model linear_;
};

/// The nearest point gives energy by itself.
class LeastStiffening : public Stiffening {};

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
    Stiffened body(linear_);
    Finger soft(linear_), stiff(body.model());
    Wander way(5);
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

// F = -dPsi/dx: what the user does over a way is what is stored, but for the steps' squares; and with least energy the
// way may lead over the surface. Paths of 25,000 ticks, back to where they began.
TEST_P(LeastStiffening, ClosedLoopsGiveNoEnergy) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> side(0.006, 0.024), depth(0.0005, 0.004);
    for (int loop = 0; loop < 6; ++loop) {
        Stiffened body(linear_);
        Finger finger(body.model());
        finger.to({0.015, 0.015, kTop_m + 1e-4});
        std::vector<Vector3d> corner{{0.015, 0.015, kTop_m - 1e-4}};
        for (int k = 0; k < 3; ++k) corner.push_back({side(random), side(random), kTop_m - depth(random)});
        corner.push_back(corner.front());
        double given = 0.0, most = 0.0;
        finger.to(corner.front());
        Vector3d last = finger.force(), at = finger.at();
        for (std::size_t k = 1; k < corner.size(); ++k)
            for (int step = 1; step <= 2000; ++step) {
                finger.to(corner[k - 1] + step / 2000.0 * (corner[k] - corner[k - 1]));
                given += 0.5 * (finger.force() + last).dot(finger.at() - at);
                last = finger.force();
                at = finger.at();
                most = std::max(most, -given);
            }
        EXPECT_GT(most, 0.25 * kCurve.energy_j) << "deep enough to stiffen";
        EXPECT_LE(given, 1e-3 * most);
    }
}

/// What a scene may name beside dents that stiffen.
struct Law {
    const char* name;
    void (*ask)(Tables&);
};
constexpr Law kLaws[] = {
    {"friction", [](Tables& t) { t.static_friction = t.kinetic_friction = 0.4; }},
    {"release", [](Tables& t) { t.options.set("contact.release_slew", 0.01); }},
    {"passivity", [](Tables& t) { t.options.set("contact.passivity", true); }},
    {"relaxation",
     [](Tables& t) {
         t.relaxation = {{0.5, 0.1}};
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

/// A model that stiffens and has a law, as codegen makes it.
class WithLaw {
public:
    WithLaw(const haptable_model& linear, ForceLaw force, const Law& law, double max_force_n) : model_(linear) {
        tables_.force = force;
        tables_.god_object = GodObject::kLeastEnergy;
        tables_.stiffening = kCurve;
        tables_.max_force_n = max_force_n;
        law.ask(tables_);
        set_laws(tables_, model_);
        model_.max_force_n = static_cast<float>(max_force_n);
        model_.stiffening = table_.data();
        for (const RelaxationTerm& term : tables_.relaxation) {
            const TickRelaxation tick = relaxation_of_tick(term);
            term_ = {float(term.share), float(tick.fall), float(tick.rise)};
            model_.term = reinterpret_cast<const float(*)[3]>(term_.data());
            model_.term_count = 1;
            model_.relaxation_reach_m = 0.005F;
        }
        haptable_lay_out(&model_);
    }
    WithLaw(const WithLaw&) = delete;
    WithLaw& operator=(const WithLaw&) = delete;
    const haptable_model& model() const { return model_; }

private:
    Tables tables_;
    std::vector<float> table_ = stiffening_table(kCurve);
    std::array<float, 3> term_{};
    haptable_model model_;
};

// Presses, goes around on the surface and comes back, in 5,000 ticks; by the mean of a motion's forces.
TEST_P(LeastStiffening, WithAnyLawClosedLoopsGiveNoEnergy) {
    for (const Law& law : kLaws) {
        if (law.name == std::string("mean")) continue;  // a clamp, which needs a force of a motor's size
        const WithLaw body(linear_, std::get<0>(GetParam()), law, 1e3);
        Finger finger(body.model());
        std::mt19937 random(13);
        std::uniform_real_distribution<double> side(0.008, 0.022), depth(0.001, 0.003);
        for (int loop = 0; loop < 3; ++loop) {
            const Vector3d above(0.015, 0.015, kTop_m + 1e-4);
            std::vector<Vector3d> corner{above, {0.015, 0.015, kTop_m - 0.002}};
            for (int k = 0; k < 2; ++k) corner.push_back({side(random), side(random), kTop_m - depth(random)});
            corner.push_back(above);
            finger.begin();
            finger.to(above);
            double given = 0.0, most = 0.0;
            Vector3d last = finger.force(), at = finger.at();
            for (std::size_t k = 1; k < corner.size(); ++k)
                for (int step = 1; step <= 1250; ++step) {
                    finger.to(corner[k - 1] + step / 1250.0 * (corner[k] - corner[k - 1]));
                    ASSERT_TRUE(finger.force().allFinite()) << law.name;
                    given += 0.5 * (finger.force() + last).dot(finger.at() - at);
                    last = finger.force();
                    at = finger.at();
                    most = std::max(most, -given);
                }
            EXPECT_GT(most, 0.0) << law.name;
            EXPECT_LE(given, 1e-3 * most) << law.name;
        }
    }
}

// Of the force, of its rise in a tick where that is limited, and of its mean.
TEST_P(LeastStiffening, WithAnyLawClampsHold) {
    constexpr double kMost_n = 0.3;
    for (const Law& law : kLaws) {
        const WithLaw body(linear_, std::get<0>(GetParam()), law, kMost_n);
        const haptable_model& model = body.model();
        Finger finger(model);
        Wander way(17);
        Vector3d last = Vector3d::Zero();
        double mean2 = 0.0, largest = 0.0;
        for (int tick = 0; tick < 6000; ++tick) {
            finger.to(way.next());
            const Vector3d force = finger.force();
            ASSERT_TRUE(force.allFinite()) << law.name << " " << tick;
            ASSERT_LE(force.norm(), kMost_n * (1.0 + 8.0 * kFloat)) << law.name << " " << tick;
            if (model.rate != nullptr) {
                ASSERT_LE(force.norm(), last.norm() + double(model.rate_n) * (1.0 + 1e-5)) << law.name << " " << tick;
            }
            mean2 += 1e-3 * (force.squaredNorm() - mean2);
            if (model.mean != nullptr) {
                ASSERT_LE(mean2, 1.01 * double(model.mean_limit_n2)) << law.name << " " << tick;
            }
            largest = std::max(largest, force.norm());
            last = force;
        }
        EXPECT_GT(largest, 0.5 * kMost_n) << law.name;
    }
}

// The firmware's sources in double: what rounding does.
TEST_P(Stiffening, RoundsAsTheLinearForceDoes) {
    Stiffened body(linear_);
    const haptable_model& model = body.model();
    Finger finger(model);
    ReferenceServo exact(model);
    Wander way(7);
    int compared = 0;
    for (int tick = 0; tick < 3000; ++tick) {
        finger.to(way.next());
        const ReferenceServo::Tick should = exact.step(finger.at());
        if (!finger.touches() || should.patch != finger.out().patch) continue;
        const double depth = (finger.at() - finger.god()).norm();
        if ((should.god - finger.god()).norm() > 1e-3 * depth || depth < 1e-4) continue;  // another minimum
        ++compared;
        // Of u 16 roundings of coordinates and where the god-object rests, times the tangent over the factor.
        EXPECT_WITHIN((finger.force() - should.force).norm(), .epsilon = 4.0 * (1e-3 + 32.0 * kFloat * kTop_m / depth),
                      .size = should.force.norm());
    }
    EXPECT_GT(compared, 500);
}

/// A cube whose every point is a spring of 500 N/m.
class StiffSprings {
public:
    explicit StiffSprings(const StiffeningCurve& curve = kCurve) : stiff_(*body_.get(), curve) {
        haptable_model& model = stiff_.model();
        model.stiffness_n_per_m = reinterpret_cast<const float(*)[6]>(blocks_.data());
        model.stiffness_limit_n_per_m = 500.0F * static_cast<float>(curve.largest_tangent(1.0));
        model.max_force_n = 1e3F;
    }
    haptable_model model() { return stiff_.model(); }

private:
    TestModel body_{box_shape(2, Vector3d(0.03, 0.03, kTop_m))};
    std::vector<std::array<float, 6>> blocks_ =
        std::vector<std::array<float, 6>>(body_.servo().free_count, {500.0F, 500.0F, 500.0F, 0.0F, 0.0F, 0.0F});
    Stiffened stiff_;
};

TEST(StiffeningForce, GrowsWithTheDentAndDoesNotStep) {
    StiffSprings body;
    Finger finger(body.model());
    finger.to({0.0145, 0.0151, kTop_m + 1e-6});
    double last = 0.0, deepest = 0.0;
    for (int k = 1; k <= 300; ++k) {
        finger.to({0.0145, 0.0151, kTop_m - 1e-5 * k});
        const double depth = (finger.god() - finger.at()).norm(), e = 0.5 * 500.0 * depth * depth;
        const double step = depth - deepest, now = finger.force().z();
        EXPECT_WITHIN(now - kCurve.factor(e) * 500.0 * depth, .epsilon = kRoot + 32.0 * kFloat, .size = now);
        EXPECT_GT(now, last);
        EXPECT_LT(now - last, 1.02 * kCurve.largest_tangent(e) * 500.0 * step);
        last = now;
        deepest = depth;
    }
    EXPECT_GT(0.5 * 500.0 * deepest * deepest, 2.0 * kCurve.energy_j);
}

// A force that grows by the tangent, not by |F| / |u|, is no jump, which a release would hold back.
TEST(StiffeningForce, IsNoJumpForARelease) {
    constexpr StiffeningCurve kSteep{{0.0, 0.0, 30.0}, 2e-3};
    StiffSprings body(kSteep);
    haptable_model model = body.model();
    model.release = haptable_release_slew_stiffening;
    model.release_n = 1e-4F;
    Finger finger(model);
    finger.to({0.0145, 0.0151, kTop_m + 1e-6});
    for (int k = 1; k <= 50; ++k) finger.to({0.0145, 0.0151, kTop_m - 5e-5 * k});
    EXPECT_EQ(finger.counters().jumps, 0U);
}

/// A body that relaxes by one half and stiffens; `held`: as friction and a hand have it.
haptable_model relaxing(StiffSprings& body, std::array<float, 3>& term, bool held) {
    Tables tables;
    tables.relaxation = {{0.5, 0.1}};
    haptable_model law{}, model = body.model();
    set_laws(tables, law);
    const TickRelaxation tick = relaxation_of_tick(tables.relaxation[0]);
    term = {0.5F, float(tick.fall), float(tick.rise)};
    model.relax = held ? haptable_relaxation_held_stiffening : haptable_relaxation_stiffening;
    model.term_count = 1;
    model.term = reinterpret_cast<const float(*)[3]>(term.data());
    model.rest_share = law.rest_share;
    model.tick_share = law.tick_share;
    model.relaxation_reach_m = 0.005F;
    return model;
}

// Fung's quasi-linear viscoelasticity: a ramp's elastic force, convolved with g(t).
TEST(StiffeningForce, RelaxesAsTheElasticForceDoes) {
    for (const bool held : {false, true}) {
        StiffSprings body;
        std::array<float, 3> term;
        Finger finger(relaxing(body, term, held));
        finger.to({0.0145, 0.0151, kTop_m + 1e-6});
        double branch = 0.0, last = 0.0;
        for (int k = 1; k <= 600; ++k) {
            finger.to({0.0145, 0.0151, kTop_m - 1e-5 * std::min(k, 150)});
            const double depth = double(static_cast<float>(kTop_m)) - finger.at().z();
            const double elastic = kCurve.factor(250.0 * depth * depth) * 500.0 * depth;
            branch = branch * (1.0 - double(term[1])) + double(term[2]) * (elastic - last);
            last = elastic;
            // The state sums 600 steps with their roundings kept.
            EXPECT_WITHIN(finger.force().z() - (0.5 * elastic + 0.5 * branch), .epsilon = kRoot + 64.0 * kFloat,
                          .size = elastic)
                << held << " " << k;
        }
        EXPECT_LT(finger.force().z(), 0.51 * last) << "half is left";
    }
}

TEST(StiffeningForce, RelaxingGivesNoEnergyOnRandomWays) {
    for (const bool held : {false, true}) {
        StiffSprings body;
        std::array<float, 3> term;
        Finger finger(relaxing(body, term, held));
        std::mt19937 random(3);
        std::uniform_real_distribution<double> depth(-0.0002, 0.0025);
        double x = -0.0002, aim = 0.0, given = 0.0, before = 0.0, most = 0.0;
        finger.to({0.0145, 0.0151, kTop_m - x});
        Vector3d at = finger.at();
        for (int tick = 0; tick < 20000; ++tick) {
            if (std::abs(aim - x) < 2e-5) aim = depth(random);
            x += std::copysign(1e-5, aim - x);
            finger.to({0.0145, 0.0151, kTop_m - x});
            given += 0.5 * (finger.force().z() + before) * (finger.at() - at).z();
            before = finger.force().z();
            at = finger.at();
            most = std::max(most, -given);
            ASSERT_LE(given, 1e-3 * kCurve.stored(250.0 * 0.0025 * 0.0025)) << held << " " << tick;
        }
        EXPECT_GT(most, 0.0);
    }
}

}  // namespace
}  // namespace haptable::test
