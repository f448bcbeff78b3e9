// SPDX-License-Identifier: GPL-2.0-or-later
// A body whose force relaxes, against closed forms of linear viscoelasticity; that it gives no energy; its dent.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/file.hpp"
#include "host/session/record.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSpring = SpringBox::kSpring;

Tables relaxing(const std::vector<RelaxationTerm>& terms) {
    Tables laws;
    laws.relaxation = terms;
    return laws;
}

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
    for (int decade = -3; decade <= 6; ++decade) {
        SCOPED_TRACE(decade);
        const RelaxationTerm term{0.4, kTick_s * std::pow(10.0, decade)};
        Press press(relaxing({term}));
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

// Of any way: the law is linear and does not change with time.
TEST(Relaxation, TenMillionTicksDoNotDrift) {
    Press press(relaxing(kEightTerms));
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
    const RelaxationTerm term{0.5, 0.5};
    for (const auto& [wait, waits_at_m] : {std::pair{5, -0.001}, {100, -0.001}, {1500, -0.001}, {400, 0.0001}}) {
        SCOPED_TRACE(wait);
        Press press(relaxing({term}));
        press.hold(0.003, 10'000);
        EXPECT_WITHIN(std::abs(press.force().z() - kSpring * 0.0015), exact(0.003));
        press.hold(waits_at_m, wait);
        EXPECT_EQ(press.force(), Vector3d::Zero());
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
    Tables laws = relaxing({{0.5, 0.5}});
    laws.options.set("contact.release_slew", 0.01);
    Press press(laws);
    const auto ramp = [&press](double from_m, double to_m) {
        for (int tick = 1; tick <= 80; ++tick) press.to(from_m + (to_m - from_m) * tick / 80.0);
    };
    ramp(-0.001, 0.003);
    press.hold(0.003, 3000);
    ramp(0.003, -0.001);
    const std::uint32_t jumps = press.finger().counters().jumps;
    ramp(-0.001, 0.003);
    EXPECT_EQ(press.finger().counters().jumps, jumps);
    EXPECT_EQ(press.finger().servo().owed_j, 0.0F);
    EXPECT_GT(press.force().z(), 0.5 * kSpring * 0.003);
}

// The servo's CSV has no dents: what reads it takes nodes for a contact.
TEST(Relaxation, ARecordNamesNoNodesOfADent) {
    Press press(relaxing({{0.5, 10.0}}));
    press.hold(0.003, 100);
    press.to(-0.001);
    ASSERT_NE(press.finger().out().vertex[0], HAPTABLE_NONE);
    const TemporaryFolder folder;
    const std::vector<std::uint32_t> node(press.model().vertex_count, 7);
    ServoRecord record({&press.model(), node.data(), "springs"}, folder.path() / "felt.csv");
    record.add(0, {FingerInput{}}, {press.finger().out()});
    record.finish();
    EXPECT_TRUE(says(read_file(folder.path() / "felt.csv"), "\n0,0,0,0,0,-1,-1,-1,0,0,0,"));
}

TEST(Relaxation, BesideTheDentTheBodyIsFresh) {
    const auto again = [](double aside_m) {
        Press press(relaxing({{0.5, 10.0}}));
        press.hold(0.003, 20'000);
        press.to(-0.001);
        press.to(-0.001, aside_m);
        return press.to(0.003, aside_m) / (kSpring * 0.003);
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
void expect_dissipation(const haptable_model& model, const Tables& laws) {
    WithLaws body(model, laws);
    Finger finger(body.model());
    Wander wander(Vector3d::Constant(-0.01), Vector3d::Constant(0.07), 1e-4, 3);
    double given_j = 0.0, moved = 0.0, lost_j = 0.0, worst = 0.0;
    for (const RelaxationTerm& term : laws.relaxation) worst = std::max(worst, term.time_s / kTick_s);
    int contact = 0;
    finger.to(wander.next());
    for (int tick = 0; tick < 60'000 && !testing::Test::HasFailure(); ++tick) {
        const Vector3d from = finger.at();
        const haptable_relaxed before = finger.relaxed();
        finger.to(wander.next());
        const haptable_relaxed& after = finger.relaxed();
        const bool goes_on = before.pressed == 0.0F || after.pressed != 0.0F;
        const bool is_new = finger.touches() && before.touches == 0;
        const double lost = goes_on && !is_new ? lost_in_tick(laws.relaxation, before, after) : 0.0;
        EXPECT_GE(lost, -8.0 * kFloat * (1.0 + worst) * std::pow(double(std::max(before.dent, after.dent)), 2)) << tick;
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
    Tables laws;
    laws.god_object = GodObject::kLeastEnergy;
    for (const double tick : {0.01, 1.0, 30.0, 1000.0}) {
        SCOPED_TRACE(tick);
        laws.relaxation = {{0.3, 1e-3 * tick}, {0.4, 7e-3 * tick}};
        expect_dissipation(*even.get(), laws);
    }
    for (const ForceLaw force : {ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
        SCOPED_TRACE(word(force));
        const ElasticBody body(cube_scene(5, 0.3), force, force == ForceLaw::kPressureMask ? 0.012 : 0.0);
        haptable_model model = body.model(GodObject::kLeastEnergy);
        model.max_force_n = 100.0F;
        laws.force = force;
        laws.relaxation = {{0.3, 0.01}, {0.4, 0.3}};
        expect_dissipation(model, laws);
    }
}

// Pressed for long, then moved aside while friction holds it: that way the body is as stiff as at once.
TEST(Relaxation, AHeldContactHasAHistoryInEachDirection) {
    Tables laws = relaxing({{0.5, 0.2}});
    laws.static_friction = laws.kinetic_friction = 2.0;
    Press press(laws);
    press.hold(0.003, 5000);
    EXPECT_WITHIN(std::abs(press.force().z() - kSpring * 0.0015), exact(0.003));
    press.to(0.003, 0.001);
    EXPECT_WITHIN(std::abs(press.force().x() + kSpring * 0.001), .epsilon = 1e-5 + kTick_s / 0.2,
                  .size = kSpring * 0.003);
    EXPECT_WITHIN(std::abs(press.force().z() - kSpring * 0.0015), exact(0.003));
    press.hold(0.003, 5000, 0.001);
    EXPECT_WITHIN(std::abs(press.force().x() + kSpring * 0.0005), exact(0.003));
    // Then it slips, and what it has of the other direction is dropped: never more than the body gives at once.
    press.to(0.003, 0.011);
    const Finger& finger = press.finger();
    EXPECT_EQ(finger.servo().contact.slips, 1);
    EXPECT_LE(finger.force().norm(), kSpring * (finger.at() - finger.god()).norm());
    EXPECT_GT(finger.force().norm(), 0.5 * kSpring * (finger.at() - finger.god()).norm());
}

// Grabbed, the body is pulled and pushed about its rest: the solid's moduli, in any direction.
TEST(Relaxation, AGrabbedBodyIsPulledToo) {
    Tables laws = relaxing({{0.6, 0.5}});
    laws.limits.grab = true;
    Press press(laws);
    ExactTerms exact_terms(laws.relaxation);
    press.to(1e-4);
    exact_terms.to(press.depth_m());
    press.grab();
    for (int tick = 0; tick < 5000; ++tick) {
        const double force_n = press.to(1e-4 + 0.002 * std::sin(0.004 * tick));
        ASSERT_WITHIN(std::abs(force_n - kSpring * exact_terms.to(press.depth_m())), exact(0.0021)) << tick;
    }
    EXPECT_LT(press.force().z(), 1.0);
}

TEST(Relaxation, WhatAPauseLeftIsForgotten) {
    Press press(relaxing({{0.5, 10.0}}));
    const auto again = [&](std::uint32_t after_us) {
        press.to(-1e-6, 0.0, after_us);
        return press.to(0.003);
    };
    const double fresh_n = again(HAPTABLE_TICK_US);
    press.hold(0.003, 20'000);
    EXPECT_LT(press.force().z(), 0.6 * kSpring * 0.003);
    EXPECT_EQ(again(HAPTABLE_SILENCE_US), fresh_n);
    press.to(-1e-6);
    EXPECT_LT(again(HAPTABLE_TICK_US), fresh_n) << "a dent is met later";
}

// ---- a finger that slides ------------------------------------------------------------------------------------------
// The servo, whose history goes with the contact, against the whole body's viscoelastic solution, whose history stays
// where it was.

constexpr double kRadius_m = 0.005, kDent_m = 0.002;

/// K(t) = g(t) K on the nodes of the surface, exactly: e = K u are the loads that would deform the body so at once, and
/// of a tick in which they go straight, f = rest e + sum share_k h_k with h_k <- h_k + rise_k de - fall_k h_k. What a
/// mask w is moved by, w . L e, is the finger's.
class WholeBody {
public:
    WholeBody(const ElasticBody& body, const RelaxationTerm& term)
        : body_(body),
          term_(term),
          tick_(relaxation_of_tick(term)),
          at_once_(VectorXd::Zero(body.compliance().rows())),
          branch_(at_once_) {}

    /// The force at a point of the top, N, that is u_m deep.
    Vector3d to(double x, double y, const Vector3d& u_m) {
        Vector3d alpha;
        const int patch = body_.patch_over(x, y, alpha);
        const VectorXd weight = body_.weights(patch, alpha);
        const double left = 1.0 - term_.share + term_.share * tick_.rise;
        const VectorXd past = term_.share * ((1.0 - tick_.fall) * branch_ - tick_.rise * at_once_);
        const Vector3d moved = gather(weight, body_.compliance() * past);
        const Vector3d force = body_.compliance_at(patch, alpha).ldlt().solve(left * u_m + moved);
        VectorXd next = -past;
        for (Eigen::Index node = 0; node < weight.size(); ++node) next.segment<3>(3 * node) += weight[node] * force;
        next /= left;
        branch_ += tick_.rise * (next - at_once_) - tick_.fall * branch_;
        at_once_ = next;
        return -force;
    }

private:
    static Vector3d gather(const VectorXd& weight, const VectorXd& u) {
        Vector3d sum = Vector3d::Zero();
        for (Eigen::Index node = 0; node < weight.size(); ++node) sum += weight[node] * u.segment<3>(3 * node);
        return sum;
    }

    const ElasticBody& body_;
    RelaxationTerm term_;
    TickRelaxation tick_;
    VectorXd at_once_, branch_;
};

struct Slid {
    double fixed = 0.0;  ///< largest difference of the normal force before the slide, as a part of it
    double sliding = 0.0;
};

/// Pressed for `hold_s`, then 10 mm along the top.
Slid slide(const ElasticBody& body, const RelaxationTerm& term, double speed, double hold_s) {
    Tables laws = body.tables({.max_force_n = body.tables().max_force_n});
    laws.relaxation = {term};
    WithLaws relaxing(body.model(), laws);
    Finger finger(relaxing.model());
    WholeBody whole(body, term);
    Slid slid;
    const double y = 0.0152;
    const int press = 20, hold = press + static_cast<int>(hold_s / kTick_s);
    const int end = hold + static_cast<int>(0.01 / (speed * kTick_s));
    finger.to({0.01, y, kTop_m + 1e-5});
    for (int tick = 1; tick <= end; ++tick) {
        const double x = 0.01 + std::max(0, tick - hold) * speed * kTick_s;
        const double depth_m = kDent_m * std::min(1.0, double(tick) / press);
        finger.to({x, y, kTop_m - depth_m});
        const Vector3d force =
            whole.to(finger.god().x(), finger.god().y(), {0.0, 0.0, finger.at().z() - finger.god().z()});
        double& worst = tick > hold ? slid.sliding : slid.fixed;
        worst = std::max(worst, std::abs(finger.force().z() - force.z()) / force.z());
    }
    return slid;
}

// Printed: docs/MATERIALS.md has the table. A slow slide has relaxed where it is; a fast one comes to what was never
// pressed.
TEST(SlidingOverARelaxingBody, IsExactAtAFixedContactAndErrsByTheHistoryThatStaysBehind) {
    const ElasticBody body(cube_scene(9, 0.3, true), ForceLaw::kPressureMask, kRadius_m);
    printf("speed x time / radius: largest error of the force after a long press, after a short one\n");
    double before = 0.0;
    for (const auto& [speed, time_s] :
         {std::pair{0.005, 0.01}, {0.005, 0.03}, {0.02, 0.03}, {0.02, 0.1}, {0.1, 0.1}, {0.1, 0.5}, {0.2, 2.0}}) {
        const RelaxationTerm term{0.5, time_s};
        const Slid after_long = slide(body, term, speed, 8.0 * time_s), after_short = slide(body, term, speed, 0.0);
        const double ratio = speed * time_s / kRadius_m;
        printf("%8.3g  %8.2g  %8.2g\n", ratio, after_long.sliding, after_short.sliding);
        EXPECT_LT(after_long.fixed, 1e-3) << "the blocks of the mask's quadratic, and float";
        EXPECT_GT(after_long.sliding, 0.8 * before) << "grows with the speed";
        EXPECT_LT(after_long.sliding, 0.51) << "it is never more than what has relaxed";
        EXPECT_LT(after_long.sliding, ratio < 0.02 ? 0.05 : 1.0);
        before = after_long.sliding;
    }
}

}  // namespace
}  // namespace haptable::test
