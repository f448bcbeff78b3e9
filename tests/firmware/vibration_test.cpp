// SPDX-License-Identifier: GPL-2.0-or-later
// modes: the force that is held, what a knock leaves, and what modes and contact gain of a hand.
#include "firmware/haptable_modes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "tests/error_of.hpp"
#include "tests/jelly.hpp"
#include "tests/moving_body.hpp"
#include "tests/scene_session.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// What a session needs of a jelly; body: null where it is held.
struct JellyParts {
    JellyParts(const Jelly& jelly, GodObject god_object, double friction)
        : model(jelly.model(god_object, friction)), modes(jelly.modes()) {}
    haptable_model model;
    haptable_modes modes;
};

/// A jelly and one finger.
struct Session : JellyParts, SceneSession {
    Session(const Jelly& jelly, GodObject god_object, double friction = 0.0, const haptable_body* body = nullptr)
        : JellyParts(jelly, god_object, friction), SceneSession(model, nullptr, body, &modes) {}
    haptable_modes_state& swung() { return *state.modes(); }
    const haptable_past& past() const { return state.account().past[0]; }
};

Vector3d force_at(const haptable_model& model, const haptable_contact& contact, const Vector3d& finger_m) {
    const float at[3] = {float(finger_m.x()), float(finger_m.y()), float(finger_m.z())};
    float nodal[3][3], force[3];
    model.force(&model, &contact, at, nodal, force);
    return to_vector(force);
}

const Vector3d kOnTop{0.0137, 0.0168, 0.03};
const Vector3d kAtNode{0.015, 0.015, 0.03};

/// Down to `depth` at 20 mm/s, and for so long there.
void press(Session& session, const Vector3d& at_m, double depth_m, int ticks) {
    for (int tick = 0; tick < ticks; ++tick)
        session.step(at_m + Vector3d(0, 0, std::max(-depth_m, 0.002 - 2e-5 * tick)));
}

// A force that is held comes to that of the body without modes, at the same point of the surface: friction keeps the
// god-object where it is. Of the interpolated force S is linear between nodes and not C, so at a node.
TEST(Modes, AForceThatIsHeldIsTheStaticOne) {
    for (const ForceLaw force : every<ForceLaw>()) {
        const Jelly ringing(jelly(force, 8)), still(jelly(force, 0));
        const Vector3d at = force == ForceLaw::kInterpolated ? kAtNode : kOnTop;
        Session session(ringing, GodObject::kNearest, 10.0);
        press(session, at, 0.003, 4000);
        ASSERT_TRUE(session.touches());
        const haptable_model whole = still.model();
        const Vector3d wanted = force_at(whole, session.contact(), at - Vector3d(0, 0, 0.003));
        // What rings yet: exp(-0.05 omega t) of it; and the rest's tables are floats of which the modes are a part.
        EXPECT_LT((session.force() - wanted).norm(), 2e-5 * wanted.norm()) << "force " << static_cast<int>(force);
        const Vector3d rest = force_at(session.model, session.contact(), at - Vector3d(0, 0, 0.003));
        EXPECT_GT(rest.norm(), 1.1 * wanted.norm()) << "the modes are a part of it";
    }
}

// After a slide, along which the modes moved each place of the surface otherwise, too: within a second to a hundredth
// of it, far below the fifth that a hand tells apart.
TEST(Modes, AForceAfterASlideComesToTheStaticOne) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8)), still(jelly(ForceLaw::kConsistent, 0));
    const haptable_model whole = still.model();
    const Vector3d from{0.0087, 0.0168, 0.03};
    for (const GodObject god_object : every<GodObject>())
        for (const double step_m : {3e-5, 3e-4}) {
            Session session(ringing, god_object, 0.5);
            press(session, from, 0.003, 1500);
            const Vector3d end = from + Vector3d(0.006, 0.0, -0.003);
            for (double way_m = 0.0; way_m < 0.006; way_m += step_m) session.step(end - Vector3d(0.006 - way_m, 0, 0));
            session.step(end);
            const auto off = [&] {
                const Vector3d wanted = force_at(whole, session.contact(), end);
                return (session.force() - wanted).norm() / wanted.norm();
            };
            EXPECT_GT(off(), 0.01) << "it swings";
            for (int tick = 0; tick < 1000; ++tick) session.step(end);
            EXPECT_LT(off(), 0.01) << "at " << step_m / kTick_s << " m/s";
        }
}

// What is left after a knock: each mode by itself, a damped cosine.
void expect_closed_form(double young_pa, int ticks) {
    Scene scene = jelly(ForceLaw::kConsistent, 8);
    scene.material.young_pa = young_pa;
    const Jelly ringing(scene);
    Session session(ringing, GodObject::kLeastEnergy);
    press(session, kOnTop, 0.004, 320);
    ASSERT_TRUE(session.touches());
    session.step(kOnTop + Vector3d(0, 0, 0.004));
    session.step(kOnTop + Vector3d(0, 0, 0.006));
    ASSERT_FALSE(session.touches());
    const haptable_modes_state begin = session.swung();
    double largest = 0.0;
    for (int tick = 1; tick <= ticks; ++tick) {
        session.step(kOnTop + Vector3d(0, 0, 0.006));
        const double t = kTick_s * tick;
        for (int k = 0; k < 8; ++k) {
            const double omega = ringing.files().omega_rad_per_s[std::size_t(k)], zeta = 0.05;
            const double damped = omega * std::sqrt(1.0 - zeta * zeta);
            const double q = double(begin.q[k]), p = double(begin.p[k]);
            const double wanted = std::exp(-zeta * omega * t) *
                                  (q * std::cos(damped * t) + (p + zeta * omega * q) / damped * std::sin(damped * t));
            const double size = std::hypot(q, p / omega);
            largest = std::max(largest, size);
            // The tick's numbers are rounded once, and so are frequency and decay; its sums keep their rounding.
            EXPECT_WITHIN(std::abs(double(session.swung().q[k]) - wanted), .count = 2.0 * omega * t + 8.0,
                          .epsilon = kFloat, .size = size)
                << "mode " << k << ", tick " << tick;
        }
    }
    EXPECT_GT(largest, 1e-5) << "it was knocked";
}

TEST(Modes, AKnockRingsAsTheClosedForm) {
    expect_closed_form(1e4, 1000);
    expect_closed_form(10.0, 6000);  // 0.4 Hz: a tick changes q by less than its rounding, now and then
}

// One mode under a finger that comes and stays: the force swings with the frequency of the body so held,
// omega_c^2 = omega^2 + phi . S phi, and falls off as exp(-zeta omega t). A midpoint step is slow by (omega_c T)^2
// / 12.
TEST(Modes, AFingerThatStaysFeelsTheRing) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 1));
    Session session(ringing, GodObject::kNearest, 10.0);
    for (int tick = 0; tick < 4; ++tick) session.step(kAtNode + Vector3d(0.0, 0.0, 0.001));
    std::vector<double> force;
    const Vector3d away(0.001, 0.0, -0.002);  // sideways is where the lowest mode goes
    session.step(kAtNode - Vector3d(0, 0, 0.002));
    for (int tick = 0; tick < 2000; ++tick) {
        session.step(kAtNode + away);
        force.push_back(session.force().x());
    }
    ASSERT_TRUE(session.touches());
    const double omega = ringing.files().omega_rad_per_s[0], zeta = 0.05;
    float nodal[3][3], s_phi[3];
    haptable_contact contact = session.contact();
    const float* phi = session.modes.shape[session.model.patch[contact.patch][std::size_t(
        std::max_element(contact.alpha, contact.alpha + 3) - contact.alpha)]];
    const float at[3] = {contact.god_object_m[0] + phi[0] * 1e-3F, contact.god_object_m[1] + phi[1] * 1e-3F,
                         contact.god_object_m[2] + phi[2] * 1e-3F};
    session.model.force(&session.model, &contact, at, nodal, s_phi);
    const double held = -1e3 * to_vector(s_phi).dot(to_vector(phi));
    const double wanted = std::sqrt(omega * omega * (1.0 - zeta * zeta) + held);
    expect_ring(force, wanted, zeta * omega);
}

// A finger that friction holds goes to and fro by 10 um a tick: modes and contact gain what it gives, f . dx, and
// dx . S dx / 2 besides, but for what the modes' damping takes.
TEST(Modes, GainWhatTheHandGave) {
    Scene scene = jelly(ForceLaw::kConsistent, 8);
    scene.body_modes->damping_ratio = 1e-4;
    const Jelly ringing(scene);
    Session session(ringing, GodObject::kNearest, 10.0);
    press(session, kAtNode, 0.003, 400);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> part(-1e-5F, 1e-5F);
    Vector3d at = kAtNode - Vector3d(0, 0, 0.003);
    session.step(at);
    double worst = 0.0, wall = 0.0;
    for (int tick = 0; tick < 500; ++tick) {
        const double before = double(session.state.account().stored_j);
        const Vector3d load = -session.force(), from = to_vector(session.past().finger_m);
        const haptable_contact contact = session.contact();
        at += Vector3d(part(random), part(random), part(random));
        session.step(at);
        ASSERT_EQ(to_vector(contact.god_object_m), to_vector(session.out[0].god_object_m));
        const Vector3d moved = to_vector(session.past().finger_m) - from;
        const Vector3d god = to_vector(contact.god_object_m);
        const double own = 0.5 * moved.dot(-force_at(session.model, contact, god + 100.0 * moved)) / 100.0;
        worst = std::max(worst, std::abs(double(session.state.account().stored_j) - before - load.dot(moved) - own));
        wall = std::max(wall, own);
    }
    // Energies are floats of some ten terms; damping takes 2 zeta omega of the swing's share in a tick.
    const double held = double(session.state.account().stored_j);
    const double omega = ringing.files().omega_rad_per_s.back();
    EXPECT_WITHIN(worst, .count = 16, .epsilon = kFloat, .size = held * (1.0 + 2e-4 * omega * kTick_s / kFloat / 16.0));
    EXPECT_LT(worst, 0.1 * wall) << "so that the wall's part is seen";
}

TEST(Modes, ABodyThatNothingHoldsFallsAndRings) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8, true));
    const haptable_body body = cube_body();
    Session session(ringing, GodObject::kLeastEnergy, 0.0, &body);
    double most_j = 0.0;
    for (int tick = 0; tick < 400; ++tick) {
        session.step(Vector3d(0.0137, 0.0168, tick < 200 ? 0.032 - 2e-5 * tick : 0.05));
        most_j = std::max(most_j, session.modes_j());
    }
    EXPECT_LT(double(session.state.body()->velocity_m_per_s[2]), -0.01) << "the finger pushed it";
    EXPECT_GT(most_j, 1e-9) << "and it rang";
}

// The paper's force has no energy of its own. What it makes as the finger slides, beyond what a wall does, is owed, and
// the force is the lower for it: what there is never rises by more.
TEST(Modes, WhatAForceMakesIsOwed) {
    Scene scene = jelly(ForceLaw::kInterpolated, 8);
    scene.body_modes->damping_ratio = 1e-4;
    const Jelly ringing(scene);
    Session session(ringing, GodObject::kNearest);
    press(session, kOnTop, 0.005, 400);
    double owed = 0.0, made = 0.0;
    for (int tick = 0; tick < 4000; ++tick) {
        const double stored = double(session.state.account().stored_j);
        const double before = stored - double(session.state.account().owed_j);
        const Vector3d load = -session.force(), from = to_vector(session.past().finger_m);
        session.step(kOnTop + Vector3d(0.008 * std::sin(0.005 * tick), 0.0, -0.005));
        ASSERT_TRUE(session.touches());
        const Vector3d moved = to_vector(session.past().finger_m) - from;
        const double allowed =
            before + load.dot(moved) + 0.5 * double(session.model.stiffness_limit_n_per_m) * moved.squaredNorm();
        const double now = double(session.state.account().stored_j) - double(session.state.account().owed_j);
        EXPECT_WITHIN(std::abs(now - allowed), .count = 16, .epsilon = kFloat,
                      .size = std::abs(allowed) + double(session.state.account().stored_j))
            << "tick " << tick;
        owed = std::max(owed, double(session.state.account().owed_j));
        made += std::max(0.0, double(session.state.account().stored_j) - stored - load.dot(moved));
    }
    EXPECT_GT(made, 0.0) << "the force made something";
    RecordProperty("owed_mj", std::to_string(1e3 * owed));
}

// Out of contact the surface swings on where it was last touched, and what is told is where the finger is.
TEST(Modes, TheSurfaceIsMetWhereItSwings) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8));
    Session session(ringing, GodObject::kLeastEnergy);
    press(session, kOnTop, 0.004, 300);
    const Vector3d away = kOnTop + Vector3d(0, 0, 0.01);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int tick = 0; tick < 200; ++tick) {
        session.step(away);
        ASSERT_EQ(session.out[0].state, HAPTABLE_FREE);
        EXPECT_EQ(to_vector(session.out[0].god_object_m), away.cast<float>().cast<double>());
        low = std::min(low, double(session.swung().met[0].shift_m[2]));
        high = std::max(high, double(session.swung().met[0].shift_m[2]));
    }
    // The lowest mode that lifts the top has 21.9 Hz: some four swings.
    EXPECT_LT(low, -1e-4);
    EXPECT_GT(high, 1e-4);
}

// What is refused, or is no number, leaves the modes to themselves.
TEST(Modes, ARefusedFingerPushesNothing) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8));
    Session session(ringing, GodObject::kLeastEnergy);
    press(session, kOnTop, 0.004, 400);
    double before = HUGE_VAL;
    for (int tick = 0; tick < 100; ++tick) {
        session.step(Vector3d(tick % 2 == 0 ? NAN : 1e30, 0.0, 0.0));
        EXPECT_EQ(session.force(), Vector3d::Zero());
        const double energy = session.modes_j();
        EXPECT_LE(energy, before);
        before = energy;
    }
    EXPECT_GT(before, 0.0);
}

TEST(Modes, OfABodyThatIsTooStiffAreRefused) {
    Scene scene = jelly(ForceLaw::kConsistent, 8);
    scene.material.young_pa = 3e7;
    scene.body_modes->line = 12;
    const std::string none = error_of([&] { Jelly{scene}; });
    EXPECT_NE(none.find(":12: body.modes: mode 1 swings with"), std::string::npos) << none;
    EXPECT_NE(none.find("remove modes"), std::string::npos) << none;
    scene.material.young_pa = 1e-3;
    const std::string slow = error_of([&] { Jelly{scene}; });
    EXPECT_NE(slow.find(":12: body.modes: mode 1 swings with"), std::string::npos) << slow;
    EXPECT_NE(slow.find("0.01 Hz at least"), std::string::npos) << slow;
    scene.material.young_pa = 5e6;
    const std::string some = error_of([&] { Jelly{scene}; });
    EXPECT_NE(some.find("write modes = "), std::string::npos) << some;
}

}  // namespace
}  // namespace haptable::test
