// SPDX-License-Identifier: GPL-2.0-or-later
// A body that rings: the force that is held, what a knock leaves, and the energy of hand, contact and modes.
#include "firmware/haptable_modes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "firmware/haptable_body_modes.h"
#include "tests/error_of.hpp"
#include "tests/hand.hpp"
#include "tests/jelly.hpp"
#include "tests/moving_body.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kTick = 0.001;

/// A held jelly and one finger.
struct Session {
    Session(const Jelly& jelly, GodObject god_object, double friction = 0.0)
        : model(jelly.model(god_object, friction)), modes(jelly.modes(model)) {
        haptable_init(&servo);
        haptable_modes_init(&state);
    }
    void step(const Vector3d& finger_m) {
        const float at[3] = {float(finger_m.x()), float(finger_m.y()), float(finger_m.z())};
        haptable_modes_step(&modes, &state, &servo, at, tick++ * 1000, &out);
    }
    Vector3d force() const { return to_vector(out.force_n); }

    haptable_model model;
    haptable_modes modes;
    haptable_servo servo{};
    haptable_modes_state state{};
    haptable_output out{};
    std::uint32_t tick = 0;
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
    for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
        const Jelly ringing(jelly(force, 8)), still(jelly(force, 0));
        const Vector3d at = force == ForceLaw::kInterpolated ? kAtNode : kOnTop;
        Session session(ringing, GodObject::kNearest, 10.0);
        press(session, at, 0.003, 4000);
        ASSERT_TRUE(haptable_touches(session.out.state));
        const haptable_model whole = still.model();
        const Vector3d wanted = force_at(whole, session.servo.contact, at - Vector3d(0, 0, 0.003));
        // What rings yet: exp(-0.05 omega t) of it; and the rest's tables are floats of which the modes are a part.
        EXPECT_LT((session.force() - wanted).norm(), 2e-5 * wanted.norm()) << "force " << static_cast<int>(force);
        const Vector3d rest = force_at(session.model, session.servo.contact, at - Vector3d(0, 0, 0.003));
        EXPECT_GT(rest.norm(), 1.1 * wanted.norm()) << "the modes are a part of it";
    }
}

// After a slide, along which the modes moved each place of the surface otherwise, too: within a second to a hundredth
// of it, far below the fifth that a hand tells apart.
TEST(Modes, AForceAfterASlideComesToTheStaticOne) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8)), still(jelly(ForceLaw::kConsistent, 0));
    const haptable_model whole = still.model();
    const Vector3d from{0.0087, 0.0168, 0.03};
    for (const GodObject god_object : {GodObject::kNearest, GodObject::kLeastEnergy})
        for (const double step_m : {3e-5, 3e-4}) {
            Session session(ringing, god_object, 0.5);
            press(session, from, 0.003, 1500);
            const Vector3d end = from + Vector3d(0.006, 0.0, -0.003);
            for (double way_m = 0.0; way_m < 0.006; way_m += step_m) session.step(end - Vector3d(0.006 - way_m, 0, 0));
            session.step(end);
            const auto off = [&] {
                const Vector3d wanted = force_at(whole, session.servo.contact, end);
                return (session.force() - wanted).norm() / wanted.norm();
            };
            EXPECT_GT(off(), 0.01) << "it swings";
            for (int tick = 0; tick < 1000; ++tick) session.step(end);
            EXPECT_LT(off(), 0.01) << "at " << step_m / kTick << " m/s";
        }
}

// What is left after a knock: each mode by itself, a damped cosine.
void expect_closed_form(double young_pa, int ticks) {
    Scene scene = jelly(ForceLaw::kConsistent, 8);
    scene.material.young_pa = young_pa;
    const Jelly ringing(scene);
    Session session(ringing, GodObject::kLeastEnergy);
    press(session, kOnTop, 0.004, 320);
    ASSERT_TRUE(haptable_touches(session.out.state));
    session.step(kOnTop + Vector3d(0, 0, 0.004));
    session.step(kOnTop + Vector3d(0, 0, 0.006));
    ASSERT_FALSE(haptable_touches(session.out.state));
    const haptable_modes_state begin = session.state;
    double largest = 0.0;
    for (int tick = 1; tick <= ticks; ++tick) {
        session.step(kOnTop + Vector3d(0, 0, 0.006));
        const double t = kTick * tick;
        for (int k = 0; k < 8; ++k) {
            const double omega = ringing.files().omega_rad_per_s[std::size_t(k)], zeta = 0.05;
            const double damped = omega * std::sqrt(1.0 - zeta * zeta);
            const double q = double(begin.swings.q[k]), p = double(begin.swings.p[k]);
            const double wanted = std::exp(-zeta * omega * t) *
                                  (q * std::cos(damped * t) + (p + zeta * omega * q) / damped * std::sin(damped * t));
            const double size = std::hypot(q, p / omega);
            largest = std::max(largest, size);
            // The tick's numbers are rounded once, and so are frequency and decay; its sums keep their rounding.
            EXPECT_WITHIN(std::abs(double(session.state.swings.q[k]) - wanted), .count = 2.0 * omega * t + 8.0,
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
    ASSERT_TRUE(haptable_touches(session.out.state));
    const double last = force.back();
    const double omega = ringing.files().omega_rad_per_s[0], zeta = 0.05;
    float nodal[3][3], s_phi[3];
    haptable_contact contact = session.servo.contact;
    const float* phi = session.modes.shape[session.model.patch[contact.patch][std::size_t(
        std::max_element(contact.alpha, contact.alpha + 3) - contact.alpha)]];
    const float at[3] = {contact.god_object_m[0] + phi[0] * 1e-3F, contact.god_object_m[1] + phi[1] * 1e-3F,
                         contact.god_object_m[2] + phi[2] * 1e-3F};
    session.model.force(&session.model, &contact, at, nodal, s_phi);
    const double held = -1e3 * to_vector(s_phi).dot(to_vector(phi));
    const double wanted = std::sqrt(omega * omega * (1.0 - zeta * zeta) + held);
    std::vector<double> crossing;  // upwards, through what it comes to
    for (std::size_t i = 1; i < 400; ++i)
        if (force[i - 1] < last && force[i] >= last)
            crossing.push_back(kTick * (double(i) - (force[i] - last) / (force[i] - force[i - 1])));
    ASSERT_GT(crossing.size(), 3U);
    const double period = (crossing.back() - crossing.front()) / double(crossing.size() - 1);
    EXPECT_NEAR(2.0 * std::numbers::pi / period, wanted, (std::pow(wanted * kTick, 2.0) / 12.0 + 2e-3) * wanted);
    const auto most = [&](std::size_t from) {
        double size = 0.0;
        for (std::size_t i = from; i < from + 60; ++i) size = std::max(size, std::abs(force[i] - last));
        return size;
    };
    EXPECT_NEAR(std::log(most(0) / most(200)) / 0.2, zeta * omega, 0.1 * zeta * omega);
}

// A finger that friction holds goes to and fro by 10 um a tick: modes and contact gain what it gives, f . dx, and
// dx . S dx / 2 besides, but for what the modes' damping takes.
TEST(Modes, GainWhatTheHandGave) {
    Scene scene = jelly(ForceLaw::kConsistent, 8);
    scene.vibration->damping_ratio = 1e-4;
    const Jelly ringing(scene);
    Session session(ringing, GodObject::kNearest, 10.0);
    press(session, kAtNode, 0.003, 400);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> part(-1e-5F, 1e-5F);
    Vector3d at = kAtNode - Vector3d(0, 0, 0.003);
    session.step(at);
    double worst = 0.0, wall = 0.0;
    for (int tick = 0; tick < 500; ++tick) {
        const double before = double(session.state.stored_j);
        const Vector3d load = -session.force(), from = to_vector(session.state.met.finger_m);
        const haptable_contact contact = session.servo.contact;
        at += Vector3d(part(random), part(random), part(random));
        session.step(at);
        ASSERT_EQ(to_vector(contact.god_object_m), to_vector(session.out.god_object_m));
        const Vector3d moved = to_vector(session.state.met.finger_m) - from;
        const Vector3d god = to_vector(contact.god_object_m);
        const double own = 0.5 * moved.dot(-force_at(session.model, contact, god + 100.0 * moved)) / 100.0;
        worst = std::max(worst, std::abs(double(session.state.stored_j) - before - load.dot(moved) - own));
        wall = std::max(wall, own);
    }
    // Energies are floats of some ten terms; damping takes 2 zeta omega of the swing's share in a tick.
    const double held = double(session.state.stored_j);
    const double omega = ringing.files().omega_rad_per_s.back();
    EXPECT_WITHIN(worst, .count = 16, .epsilon = kFloat, .size = held * (1.0 + 2e-4 * omega * kTick / kFloat / 16.0));
    EXPECT_LT(worst, 0.1 * wall) << "so that the wall's part is seen";
}

struct Found {
    double grown_j = 0.0, largest_j = 0.0;
    int contact_ticks = 0;
};

// Every second the hand wants to be elsewhere, in the jelly or over it, and knocks.
Found play(const Jelly& ringing, GodObject god_object, double friction, std::uint32_t seed, int seconds) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> over(0.002, 0.028), height(0.02, 0.035);
    Session session(ringing, god_object, friction);
    Hand hand;
    hand.at_m = {0.015, 0.015, 0.045};
    hand.damp(double(session.model.stiffness_limit_n_per_m));
    Found found;
    double least = HUGE_VAL;
    for (int tick = 0; tick < 1000 * seconds; ++tick) {
        if (tick % 1000 == 0) {
            hand.wants_m = {over(random), over(random), height(random)};
            least = HUGE_VAL;  // wanting costs energy
        }
        session.step(hand.at_m);
        const double all = hand.energy() + double(session.state.stored_j);
        found.contact_ticks += haptable_touches(session.out.state);
        found.largest_j = std::max(found.largest_j, all);
        found.grown_j = std::max(found.grown_j, all - least);
        least = std::min(least, all);
        hand.move(session.force());
    }
    return found;
}

TEST(Modes, EnergyNeverGrows) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8));
    const int sessions = asked("HAPTABLE_SESSIONS", 12), seconds = asked("HAPTABLE_SECONDS", 4);
    int contact_ticks = 0;
    for (int seed = 0; seed < sessions; ++seed) {
        const Found found = play(ringing, GodObject::kLeastEnergy, seed % 2 == 0 ? 0.0 : 0.6,
                                 static_cast<std::uint32_t>(seed), seconds);
        EXPECT_WITHIN(found.grown_j, .count = 8, .epsilon = kFloat, .size = found.largest_j) << "session " << seed;
        contact_ticks += found.contact_ticks;
    }
    EXPECT_GT(contact_ticks, 100 * sessions * seconds);
}

/// All that a tick of a body that nothing holds changes.
struct Moving {
    explicit Moving(const Session& session) : servo(session.servo), swings(session.state) {}
    haptable_body_state body{};
    haptable_servo servo;
    haptable_modes_state swings;
};

// The same of a cube on a floor that nothing holds: tick by tick what haptable_body_modes_step does, with a look
// between what is taken back and the tick's motion.
TEST(Modes, EnergyOfABodyThatNothingHoldsNeverGrows) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8, true));
    const int sessions = asked("HAPTABLE_SESSIONS", 8), seconds = asked("HAPTABLE_SECONDS", 4);
    int contact_ticks = 0;
    for (int seed = 0; seed < sessions; ++seed) {
        haptable_body body = cube_body();
        add_gravity(body);
        add_floor(body, 0.0, 0.5);
        std::mt19937 random(static_cast<std::uint32_t>(seed));
        std::uniform_real_distribution<double> part(-1.0, 1.0);
        Session session(ringing, GodObject::kLeastEnergy);
        haptable_body_state state;
        haptable_body_init(&body, &state);
        Hand hand;
        hand.at_m = {0.015, 0.015, 0.045};
        hand.damp(double(session.model.stiffness_limit_n_per_m));
        double least = HUGE_VAL, grown = 0.0, largest = 0.0;
        for (int tick = 0; tick < 1000 * seconds; ++tick) {
            if (tick % 1000 == 0) {
                if ((position_of(state) - to_vector(body.centre_m)).norm() > 0.1) haptable_body_init(&body, &state);
                hand.wants_m = position_of(state) + 0.02 * Vector3d(part(random), part(random), part(random));
                least = HUGE_VAL;  // wanting costs energy
            }
            const float finger[3] = {float(hand.at_m.x()), float(hand.at_m.y()), float(hand.at_m.z())};
            const float before = session.state.stored_j - state.stored_j[0];
            float inside[3];
            haptable_body_push push;
            Moving whole(session);
            whole.body = state;
            haptable_output out;
            haptable_body_modes_step(&session.modes, &body, &whole.body, &whole.swings, &whole.servo, finger,
                                     session.tick * 1000, &out);
            haptable_body_from_world(&body, &state, finger, inside);
            haptable_modes_step(&session.modes, &session.state, &session.servo, inside, session.tick++ * 1000,
                                &session.out);
            float made = haptable_body_push_of(&session.model, &body, &session.servo, &state, 0, finger,
                                               session.servo.finger_m, &session.out, &push);
            for (int c = 0; c < 3; ++c) push.at_m[c] = inside[c];
            made += (session.state.stored_j - state.stored_j[0]) - before;
            haptable_body_brake(&body, &state, made);
            const double all = energy_of(body, state) + hand.energy() + double(session.state.stored_j);
            haptable_body_move(&body, &state, &push, 1);
            ASSERT_EQ(to_vector(whole.body.velocity_m_per_s), to_vector(state.velocity_m_per_s)) << "tick " << tick;
            ASSERT_EQ(to_vector(whole.body.spin_rad_per_s), to_vector(state.spin_rad_per_s)) << "tick " << tick;
            ASSERT_EQ(to_vector(out.force_n), to_vector(state.given_n[0])) << "tick " << tick;
            contact_ticks += haptable_touches(session.out.state);
            largest = std::max(largest, all);
            grown = std::max(grown, all - least);
            least = std::min(least, all);
            hand.move(to_vector(state.given_n[0]));
        }
        EXPECT_WITHIN(grown, .count = 8, .epsilon = kFloat, .size = largest) << "session " << seed;
    }
    EXPECT_GT(contact_ticks, 20 * sessions * seconds);
}

TEST(Modes, ABodyThatNothingHoldsFallsAndRings) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8, true));
    haptable_body body = cube_body();
    Session session(ringing, GodObject::kLeastEnergy);
    haptable_body_state state;
    haptable_body_init(&body, &state);
    double most_j = 0.0;
    for (int tick = 0; tick < 400; ++tick) {
        const float at[3] = {0.0137F, 0.0168F, tick < 200 ? 0.032F - 2e-5F * static_cast<float>(tick) : 0.05F};
        haptable_body_modes_step(&session.modes, &body, &state, &session.state, &session.servo, at,
                                 static_cast<std::uint32_t>(tick) * 1000, &session.out);
        most_j = std::max(most_j, double(haptable_modes_energy(&session.modes, &session.state.swings)));
    }
    EXPECT_LT(double(state.velocity_m_per_s[2]), -0.01) << "the finger pushed it";
    EXPECT_GT(most_j, 1e-9) << "and it rang";
}

// A shift that lagged when contact ended follows so slowly that a finger which waits is not jumped at.
TEST(Modes, AShiftThatLagsFollowsSlowly) {
    const Jelly ringing(jelly(ForceLaw::kConsistent, 8));
    Session session(ringing, GodObject::kLeastEnergy);
    press(session, kOnTop, 0.002, 300);
    for (int tick = 0; tick < 5000; ++tick) session.step(kOnTop + Vector3d(0, 0, 0.001 + 2e-6 * tick));
    session.state.met.shift_m[2] = 3e-4F;
    for (int tick = 0; tick < 299; ++tick) {
        const float before = session.state.met.shift_m[2];
        session.step(kOnTop + Vector3d(0, 0, 0.02));
        ASSERT_NEAR(double(before - session.state.met.shift_m[2]), 1e-6, 1e-9) << tick;
    }
    session.step(kOnTop + Vector3d(0, 0, 0.02));
    session.step(kOnTop + Vector3d(0, 0, 0.02));
    EXPECT_NEAR(double(session.state.met.shift_m[2]), 0.0, 1e-9);
}

// The paper's force has no energy of its own. What it makes as the finger slides, beyond what a wall does, is taken out
// of the swing, as far as there is one.
TEST(Modes, WhatAForceMakesIsTakenOutOfTheSwing) {
    Scene scene = jelly(ForceLaw::kInterpolated, 8);
    scene.vibration->damping_ratio = 1e-4;
    const Jelly ringing(scene);
    Session session(ringing, GodObject::kNearest);
    press(session, kOnTop, 0.005, 400);
    int taken = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const haptable_modes_state before = session.state;
        session.step(kOnTop + Vector3d(0.008 * std::sin(0.005 * tick), 0.0, -0.005));
        ASSERT_TRUE(haptable_touches(session.out.state));
        const Vector3d moved = to_vector(session.state.met.finger_m) - to_vector(before.met.finger_m);
        const double allowed = double(before.stored_j) + to_vector(before.met.load_n).dot(moved) +
                               0.5 * double(session.model.stiffness_limit_n_per_m) * moved.squaredNorm();
        const Vector3d dent = to_vector(session.servo.finger_m) - to_vector(session.out.god_object_m);
        const double held = 0.5 * std::abs(session.force().dot(dent)) +
                            double(haptable_modes_energy(&session.modes, &session.state.swings));
        const bool swings =
            std::any_of(session.state.swings.p, session.state.swings.p + 8, [](float p) { return p != 0.0F; });
        const Bound rounding{.count = 16, .epsilon = kFloat, .size = allowed};
        if (swings) {
            EXPECT_WITHIN(held - allowed, rounding) << "tick " << tick;
        }
        taken += !swings || std::abs(held - allowed) < rounding.value();
    }
    EXPECT_GT(taken, 20) << "the force made something";
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
        ASSERT_EQ(session.out.state, HAPTABLE_FREE);
        EXPECT_EQ(to_vector(session.out.god_object_m), away.cast<float>().cast<double>());
        low = std::min(low, double(session.state.met.shift_m[2]));
        high = std::max(high, double(session.state.met.shift_m[2]));
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
        const double energy = double(haptable_modes_energy(&session.modes, &session.state.swings));
        EXPECT_LE(energy, before);
        before = energy;
    }
    EXPECT_GT(before, 0.0);
}

TEST(Modes, OfABodyThatIsTooStiffAreRefused) {
    Scene scene = jelly(ForceLaw::kConsistent, 8);
    scene.material.young_pa = 3e7;
    scene.vibration->line = 12;
    const std::string none = error_of([&] { Jelly{scene}; });
    EXPECT_NE(none.find(":12: body.modes: mode 1 swings with"), std::string::npos) << none;
    EXPECT_NE(none.find("remove modes"), std::string::npos) << none;
    scene.material.young_pa = 5e6;
    const std::string some = error_of([&] { Jelly{scene}; });
    EXPECT_NE(some.find("write modes = "), std::string::npos) << some;
}

}  // namespace
}  // namespace haptable::test
