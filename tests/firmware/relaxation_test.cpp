// SPDX-License-Identifier: GPL-2.0-or-later
// A body whose force relaxes, against closed forms of linear viscoelasticity; that it gives no energy; its dent.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "codegen/laws.hpp"
#include "host/base/file.hpp"
#include "host/session/record.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kSpring = 500.0;

/// A model that relaxes by these terms, and what it remembers.
class Relaxing {
public:
    Relaxing(const haptable_model& body, const std::vector<RelaxationTerm>& terms, bool held = false) : model_(body) {
        Tables tables;
        tables.relaxation = terms;
        haptable_model law{};
        set_laws(tables, law);
        for (const RelaxationTerm& term : terms) {
            const TickRelaxation tick = relaxation_of_tick(term);
            row_.push_back({float(term.share), float(tick.fall), float(tick.rise)});
        }
        model_.relax = held ? haptable_relaxation_held : law.relax;
        model_.term_count = static_cast<std::uint8_t>(terms.size());
        model_.term = reinterpret_cast<const float(*)[3]>(row_.data());
        model_.rest_share = law.rest_share;
        model_.tick_share = law.tick_share;
        model_.relaxation_reach_m = 0.005F;
    }
    Relaxing(const Relaxing&) = delete;
    Relaxing& operator=(const Relaxing&) = delete;
    haptable_model& model() { return model_; }

private:
    haptable_model model_;
    std::vector<std::array<float, 3>> row_;
};

/// A cube whose every point is a spring of 500 N/m at once.
class Springs {
public:
    Springs() : blocks_(body_.servo().free_count, {500.0F, 500.0F, 500.0F, 0.0F, 0.0F, 0.0F}) {}
    haptable_model model() const {
        haptable_model model = *body_.get();
        model.stiffness_n_per_m = reinterpret_cast<const float(*)[6]>(blocks_.data());
        model.stiffness_limit_n_per_m = 500.0F;
        return model;
    }

private:
    TestModel body_{box_shape(2, Vector3d(0.03, 0.03, kTop_m))};
    std::vector<std::array<float, 6>> blocks_;
};

/// The finger over the middle of the top.
class Press {
public:
    explicit Press(Relaxing& body) : finger_(body.model()) { finger_.to({0.0145, 0.0151, kTop_m + 1e-6}); }
    /// One tick; the force outwards, N.
    double to(double depth_m) { return finger_.to({0.0145, 0.0151, kTop_m - depth_m}).force_n[2]; }
    /// As the servo saw it.
    double depth_m() const { return double(static_cast<float>(kTop_m)) - finger_.at().z(); }
    Finger& finger() { return finger_; }

private:
    Finger finger_;
};

/// A finger's place is a float: what it is off by, as a part of `depth_m`; and the law's own roundings.
Bound exact(double depth_m) { return {.count = 1.0, .epsilon = 1e-5, .size = kSpring * depth_m}; }

/// g(t) of a standard linear solid, convolved with a ramp of `speed` that ends at `end_s`, m.
double ramped_m(const RelaxationTerm& term, double speed, double end_s, double t_s) {
    const double tau = term.time_s, ramp_s = std::min(t_s, end_s);
    const double branch = -tau * std::expm1(-ramp_s / tau) * std::exp(-(t_s - ramp_s) / tau);
    return speed * ((1.0 - term.share) * ramp_s + term.share * branch);
}

// Nine decades of relaxation time over tick.
TEST(Relaxation, ARampThatIsHeldIsTheClosedFormOfTheStandardLinearSolid) {
    const Springs springs;
    for (int decade = -3; decade <= 6; ++decade) {
        SCOPED_TRACE(decade);
        const RelaxationTerm term{0.4, kTick_s * std::pow(10.0, decade)};
        Relaxing body(springs.model(), {term});
        Press press(body);
        constexpr double kSpeed = 0.03, kDepth_m = 0.003;  // 0.03 mm a tick
        constexpr int kRamp = 100;
        const int end = kRamp + std::clamp(static_cast<int>(5.0 * term.time_s / kTick_s), 100, 3'000'000);
        press.to(0.0);
        for (int tick = 1; tick <= end; ++tick) {
            const double force_n = press.to(kSpeed * kTick_s * std::min(tick, kRamp));
            const double exact_m = ramped_m(term, kSpeed, kRamp * kTick_s, tick * kTick_s);
            ASSERT_WITHIN(std::abs(force_n - kSpring * exact_m), exact(kDepth_m)) << "tick " << tick;
        }
    }
}

// J(t) = (1 - share exp(-(1 - share) t / time)) / (1 - share) times the depth at once: a finger that goes so feels one
// force.
TEST(Relaxation, UnderAConstantForceTheBodyCreeps) {
    const Springs springs;
    for (const double time_s : {0.3, 3.0, 30.0}) {
        const RelaxationTerm term{0.5, time_s};
        Relaxing body(springs.model(), {term});
        Press press(body);
        const double rest = 1.0 - term.share, at_once_m = 0.001;
        const auto creep_m = [&](double t_s) {
            return at_once_m * (1.0 - term.share * std::exp(-rest * t_s / term.time_s)) / rest;
        };
        for (int tick = 0; tick < static_cast<int>(8.0 * time_s / kTick_s); ++tick) {
            const double force_n = press.to(creep_m(tick * kTick_s));
            // The first press took a tick, in which the term fell by tick / (2 time).
            ASSERT_WITHIN(std::abs(force_n - kSpring * at_once_m),
                          .epsilon = 1e-5 + 0.5 * term.share * kTick_s / time_s, .size = kSpring * creep_m(1e9))
                << "tick " << tick;
        }
    }
}

/// F over u of an oscillation about a depth, once the depth itself has relaxed.
std::complex<double> modulus(Relaxing& body, double radian_per_s, double settle_s) {
    Press press(body);
    const double mean_m = 0.002, amplitude_m = 0.0005;
    const auto ticks = static_cast<int>(std::round(2.0 * std::numbers::pi / radian_per_s / kTick_s));
    const double step = 2.0 * std::numbers::pi / ticks;
    std::complex<double> force, depth;
    const int settle = ticks * (1 + static_cast<int>(settle_s / kTick_s) / ticks);
    for (int tick = -settle; tick < ticks; ++tick) {
        const double force_n = press.to(mean_m + amplitude_m * std::sin(step * tick));
        if (tick < 0) continue;
        const std::complex<double> wave = std::polar(1.0, -step * tick);
        force += force_n * wave;
        depth += press.depth_m() * wave;
    }
    return force / depth;
}

// G' = rest + share (w time)^2 / (1 + (w time)^2), G'' = share w time / (1 + (w time)^2).
TEST(Relaxation, OscillationHasTheStorageAndTheLossModulusOverThreeDecades) {
    const Springs springs;
    const RelaxationTerm term{0.6, 2.0};
    Relaxing body(springs.model(), {term});
    for (double w_tau = 0.03; w_tau < 31.0; w_tau *= std::sqrt(10.0)) {
        SCOPED_TRACE(w_tau);
        const double w = w_tau / term.time_s, per_tick = w * kTick_s;
        const std::complex<double> got = modulus(body, w, 14.0 * term.time_s) / kSpring;
        const std::complex<double> iw(0.0, w_tau), wanted = 1.0 - term.share + term.share * iw / (1.0 + iw);
        // Straight ticks leave (w tick)^2 / 12 of the wave out; exp(-14) of the first press is left.
        EXPECT_WITHIN(std::abs(got - wanted), .epsilon = 1e-5 + per_tick * per_tick, .size = 1.0);
    }
}

/// The recursion in double.
class ExactTerms {
public:
    explicit ExactTerms(const std::vector<RelaxationTerm>& terms) : term_(terms), branch_(terms.size()) {}
    double to(double depth_m) {
        double load = rest_share(term_) * depth_m;
        for (std::size_t k = 0; k < term_.size(); ++k) {
            const TickRelaxation tick = relaxation_of_tick(term_[k]);
            branch_[k] += tick.rise * (depth_m - depth_m_) - tick.fall * branch_[k];
            load += term_[k].share * branch_[k];
        }
        depth_m_ = depth_m;
        return load;
    }

private:
    std::vector<RelaxationTerm> term_;
    std::vector<double> branch_;
    double depth_m_ = 0.0;
};

const std::vector<RelaxationTerm> kEightTerms = {{0.1, 3e-4}, {0.1, 3e-3}, {0.1, 0.03},  {0.1, 0.3},
                                                 {0.1, 3.0},  {0.1, 30.0}, {0.1, 300.0}, {0.1, 3000.0}};

TEST(Relaxation, TenMillionTicksDoNotDrift) {
    const Springs springs;
    Relaxing body(springs.model(), kEightTerms);
    Press press(body);
    ExactTerms exact_terms(kEightTerms);
    double largest = 0.0;
    for (int tick = 0; tick < 10'000'000; ++tick) {
        const double force_n = press.to(0.003 + 0.0005 * std::sin(0.0021 * tick) * std::sin(1.3e-5 * tick));
        largest = std::max(largest, std::abs(force_n - kSpring * exact_terms.to(press.depth_m())));
    }
    EXPECT_WITHIN(largest, exact(0.003));
}

// After a long press the surface lies share of its depth low, and comes up with the creep's time.
TEST(Relaxation, AnEarlySecondPressMeetsTheDent) {
    const Springs springs;
    const RelaxationTerm term{0.5, 0.5};
    for (const auto& [wait, waits_at_m] : {std::pair{5, -0.001}, {100, -0.001}, {1500, -0.001}, {400, 0.0001}}) {
        SCOPED_TRACE(wait);
        Relaxing body(springs.model(), {term});
        Press press(body);
        for (int tick = 0; tick < 10'000; ++tick) press.to(0.003);
        EXPECT_WITHIN(std::abs(press.finger().force().z() - kSpring * 0.0015), exact(0.003));
        for (int tick = 0; tick < wait; ++tick) press.to(waits_at_m);
        EXPECT_EQ(press.finger().force(), Vector3d::Zero());
        EXPECT_EQ(press.finger().touches(), waits_at_m > 0.0) << "in the dent, under the shape at rest";
        const auto dent_m = [&term](int ticks) {
            return term.share * 0.003 * std::exp(-(1.0 - term.share) * ticks * kTick_s / term.time_s);
        };
        Vector3d drawn = Vector3d::Zero();
        for (const auto& load : press.finger().out().nodal_force_n) drawn += to_vector(load);
        const double tick_error = 2.0 * kTick_s / term.time_s;  // of the tick in which it lifted off
        EXPECT_WITHIN(std::abs(-drawn.z() - kSpring * dent_m(wait)), .epsilon = 1e-5 + tick_error,
                      .size = kSpring * 0.003);
        // Down again, 0.05 mm a tick: nothing until the surface, then a spring.
        for (int tick = 1; tick < 60; ++tick) {
            const double depth_m = 5e-5 * tick, force_n = press.to(depth_m);
            const double low_m = dent_m(wait + tick);
            if (depth_m < low_m - 5e-5) {
                ASSERT_EQ(force_n, 0.0) << depth_m;
                ASSERT_TRUE(press.finger().touches());
            }
            if (depth_m > low_m + tick_error * 0.003) {
                ASSERT_WITHIN(std::abs(force_n - kSpring * (depth_m - low_m)), .epsilon = 0.05,
                              .size = kSpring * depth_m);
                ASSERT_GT(force_n, 0.0);
            }
        }
    }
}

// Over the dent a small force comes up as fast as the body is stiff at once: that is not a jump, which would be owed.
TEST(Relaxation, ReleaseTakesASecondPressForNoJump) {
    const Springs springs;
    haptable_model soft_end = springs.model();
    soft_end.release = haptable_release_slew;
    soft_end.release_n = 0.01F;
    Relaxing body(soft_end, {{0.5, 0.5}});
    Press press(body);
    const auto to = [&press](double from_m, double to_m) {
        for (int tick = 1; tick <= 80; ++tick) press.to(from_m + (to_m - from_m) * tick / 80.0);
    };
    to(-0.001, 0.003);
    for (int tick = 0; tick < 3000; ++tick) press.to(0.003);
    to(0.003, -0.001);
    const std::uint32_t jumps = press.finger().counters().jumps;
    to(-0.001, 0.003);
    EXPECT_EQ(press.finger().counters().jumps, jumps);
    EXPECT_EQ(press.finger().servo().owed_j, 0.0F);
    EXPECT_GT(press.finger().force().z(), 0.5 * kSpring * 0.003);
}

// The servo's CSV has no dents: what reads it takes nodes for a contact.
TEST(Relaxation, ARecordNamesNoNodesOfADent) {
    const Springs springs;
    Relaxing body(springs.model(), {{0.5, 10.0}});
    Press press(body);
    for (int tick = 0; tick < 100; ++tick) press.to(0.003);
    press.to(-0.001);
    ASSERT_NE(press.finger().out().vertex[0], HAPTABLE_NONE);
    const TemporaryFolder folder;
    const std::vector<std::uint32_t> node(body.model().vertex_count, 7);
    ServoRecord record({&body.model(), node.data(), "springs"}, folder.path() / "felt.csv");
    record.add(0, {FingerInput{}}, {press.finger().out()});
    record.finish();
    EXPECT_NE(read_file(folder.path() / "felt.csv").find("\n0,0,0,0,0,-1,-1,-1,0,0,0,"), std::string::npos);
}

TEST(Relaxation, BesideTheDentTheBodyIsFresh) {
    const Springs springs;
    Relaxing body(springs.model(), {{0.5, 10.0}});
    const auto again = [&](double aside_m) {
        Press press(body);
        for (int tick = 0; tick < 20'000; ++tick) press.to(0.003);
        press.to(-0.001);
        press.finger().to({0.0145 + aside_m, 0.0151, kTop_m + 0.001});
        return double(press.finger().to({0.0145 + aside_m, 0.0151, kTop_m - 0.003}).force_n[2]) / (kSpring * 0.003);
    };
    const double there = again(0.0);
    EXPECT_LT(there, 0.6);
    EXPECT_WITHIN(std::abs(again(0.0025) - 0.5 * (1.0 + there)), .epsilon = 1e-3) << "half of the reach, half of it";
    EXPECT_WITHIN(std::abs(again(0.0051) - 1.0), .epsilon = 1e-3);
}

/// What the terms lose in a tick, J: the work on each, the surface going straight, less what it stores more.
double lost_in_tick(const std::vector<RelaxationTerm>& terms, const haptable_relaxed& before,
                    const haptable_relaxed& after) {
    const double change = double(after.dent) - double(before.dent);
    double lost = 0.0;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        const double from = double(before.term[k].branch[0]), to = double(after.term[k].branch[0]);
        lost += terms[k].share *
                (terms[k].time_s / kTick_s * change * (change - (to - from)) - 0.5 * (to - from) * (to + from));
    }
    return lost;
}

/// A finger wanders through the body. Forces times the motion that led to them give no more than the way between.
void expect_dissipation(const haptable_model& model, const std::vector<RelaxationTerm>& terms) {
    constexpr double kStep_m = 1e-4;
    Relaxing body(model, terms);
    Finger finger(body.model());
    std::mt19937 random(3);
    std::uniform_real_distribution<double> anywhere(-0.01, 0.07);
    Vector3d x(0.07, 0.07, 0.07), aim = x;
    double given_j = 0.0, moved = 0.0, lost_j = 0.0, worst = 0.0;
    for (const RelaxationTerm& term : terms) worst = std::max(worst, term.time_s / kTick_s);
    int contact = 0;
    finger.to(x);
    for (int tick = 0; tick < 60'000 && !testing::Test::HasFailure(); ++tick) {
        if ((aim - x).norm() < kStep_m) aim = {anywhere(random), anywhere(random), anywhere(random)};
        x += kStep_m * (aim - x).normalized();
        const Vector3d from = finger.at();
        const haptable_relaxed before = finger.relaxed();
        finger.to(x);
        const bool goes_on = before.pressed == 0.0F || finger.relaxed().pressed != 0.0F;
        const bool is_new = finger.touches() && before.touches == 0;
        const double lost = goes_on && !is_new ? lost_in_tick(terms, before, finger.relaxed()) : 0.0;
        EXPECT_GE(lost,
                  -8.0 * kFloat * (1.0 + worst) * std::pow(double(std::max(before.dent, finger.relaxed().dent)), 2))
            << tick;
        lost_j += lost;
        contact += finger.touches();
        const Vector3d step = finger.at() - from;
        given_j += finger.force().dot(step);
        moved += finger.force().norm() * step.norm();
        EXPECT_LE(given_j, 64.0 * kFloat * moved) << tick;
    }
    EXPECT_GT(lost_j, 0.0);
    EXPECT_LT(given_j, 0.0);
    EXPECT_GT(contact, 1000);
}

// Of made-up blocks; then of a body's own compliance, between nodes and under masks.
TEST(Relaxation, LeastEnergyGivesNothingAndEveryTickDissipates) {
    const TestModel even(l_shape(6, 0.06), -1e9, GodObject::kLeastEnergy);
    for (const double tick : {0.01, 1.0, 30.0, 1000.0}) {
        SCOPED_TRACE(tick);
        expect_dissipation(*even.get(), {{0.3, 1e-3 * tick}, {0.4, 7e-3 * tick}});
    }
    for (const ForceLaw force : {ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
        SCOPED_TRACE(word(force));
        const ElasticBody body(cube_scene(5, 0.3), force, force == ForceLaw::kPressureMask ? 0.012 : 0.0);
        haptable_model model = body.model(GodObject::kLeastEnergy);
        model.max_force_n = 100.0F;
        expect_dissipation(model, {{0.3, 0.01}, {0.4, 0.3}});
    }
}

// Pressed for long, then moved aside while friction holds it: that way the body is as stiff as at once.
TEST(Relaxation, AHeldContactHasAHistoryInEachDirection) {
    const Springs springs;
    haptable_model rough = springs.model();
    rough.god_object = haptable_god_object_friction;
    rough.frictionless = haptable_god_object_nearest;
    rough.static_friction = rough.kinetic_friction = 2.0F;
    const RelaxationTerm term{0.5, 0.2};
    Relaxing body(rough, {term}, true);
    Finger finger(body.model());
    finger.to({0.0145, 0.0151, kTop_m + 1e-6});
    for (int tick = 0; tick < 5000; ++tick) finger.to({0.0145, 0.0151, kTop_m - 0.003});
    EXPECT_WITHIN(std::abs(finger.force().z() - kSpring * 0.0015), exact(0.003));
    finger.to({0.0155, 0.0151, kTop_m - 0.003});
    EXPECT_WITHIN(std::abs(finger.force().x() + kSpring * 0.001), .epsilon = 1e-5 + kTick_s / term.time_s,
                  .size = kSpring * 0.003);
    EXPECT_WITHIN(std::abs(finger.force().z() - kSpring * 0.0015), exact(0.003));
    for (int tick = 0; tick < 5000; ++tick) finger.to({0.0155, 0.0151, kTop_m - 0.003});
    EXPECT_WITHIN(std::abs(finger.force().x() + kSpring * 0.0005), exact(0.003));
    // Then it slips, and what it has of the other direction is dropped: never more than the body gives at once.
    finger.to({0.0255, 0.0151, kTop_m - 0.003});
    EXPECT_EQ(finger.servo().contact.slips, 1);
    EXPECT_LE(finger.force().norm(), kSpring * (finger.at() - finger.god()).norm());
    EXPECT_GT(finger.force().norm(), 0.5 * kSpring * (finger.at() - finger.god()).norm());
}

// Grabbed, the body is pulled and pushed about its rest: the solid's moduli, in any direction.
TEST(Relaxation, AGrabbedBodyIsPulledToo) {
    const Springs springs;
    haptable_model grabbed = springs.model();
    grabbed.ungrabbed = grabbed.god_object;
    grabbed.god_object = haptable_god_object_grab;
    const RelaxationTerm term{0.6, 0.5};
    Relaxing body(grabbed, {term}, true);
    haptable_room room{};
    haptable_servo& servo = room.fingers.servo[0];
    haptable_output out;
    haptable_servo_init(&servo);
    std::uint32_t time_us = 0;
    ExactTerms exact_terms({term});
    const auto to = [&](double x, double depth_m) {
        const float at[3] = {float(0.0145 + x), 0.0151F, float(kTop_m - depth_m)};
        haptable_servo_step(&body.model(), &servo, at, time_us += HAPTABLE_TICK_US, &out);
        return double(float(kTop_m)) - double(at[2]);
    };
    to(0.0, -1e-6);
    exact_terms.to(to(0.0, 1e-4));
    haptable_servo_buttons(&servo, HAPTABLE_BUTTON_GRAB);
    for (int tick = 0; tick < 5000; ++tick) {
        const double force = kSpring * exact_terms.to(to(0.0, 1e-4 + 0.002 * std::sin(0.004 * tick)));
        ASSERT_WITHIN(std::abs(double(out.force_n[2]) - force), exact(0.0021)) << tick;
    }
    EXPECT_LT(out.force_n[2], 1.0F);
}

TEST(Relaxation, WhatAPauseLeftIsForgotten) {
    const Springs springs;
    Relaxing body(springs.model(), {{0.5, 10.0}});
    Finger finger(body.model());
    const auto press = [&](std::uint32_t after_us) {
        finger.to({0.0145, 0.0151, kTop_m + 1e-6}, after_us);
        return finger.to({0.0145, 0.0151, kTop_m - 0.003}).force_n[2];
    };
    const float fresh_n = press(HAPTABLE_TICK_US);
    for (int tick = 0; tick < 20'000; ++tick) finger.to({0.0145, 0.0151, kTop_m - 0.003});
    EXPECT_LT(finger.force().z(), 0.6 * kSpring * 0.003);
    EXPECT_EQ(press(HAPTABLE_SILENCE_US), fresh_n);
    EXPECT_LT((finger.to({0.0145, 0.0151, kTop_m + 1e-6}), press(HAPTABLE_TICK_US)), fresh_n) << "a dent is met later";
}

}  // namespace
}  // namespace haptable::test
