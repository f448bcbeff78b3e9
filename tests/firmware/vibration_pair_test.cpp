// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers on a body that rings: forces that are held, the ring under both, and the energy of hands, contacts and
// modes.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numbers>
#include <random>

#include "firmware/haptable_body_modes.h"
#include "firmware/haptable_body_modes_pair.h"
#include "tests/hand.hpp"
#include "tests/jelly.hpp"
#include "tests/moving_body.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kTick = 0.001;

Scene for_two(ForceLaw force, int modes) {
    Scene scene = jelly(force, modes);
    scene.contact.fingers = 2;
    return scene;
}

/// The jelly of most tests; its damping is a ten thousandth, or 0.05.
const Jelly& ringing_jelly(bool is_damped = true) {
    static const Jelly damped(for_two(ForceLaw::kConsistent, 8));
    static const Jelly undamped([] {
        Scene scene = for_two(ForceLaw::kConsistent, 8);
        scene.vibration->damping_ratio = 1e-4;
        return scene;
    }());
    return is_damped ? damped : undamped;
}

/// A held jelly and two fingers.
struct PairSession {
    PairSession(const Jelly& jelly, GodObject god_object, double friction = 0.0)
        : model(jelly.model(god_object, friction)), tables(jelly.pair(model, god_object)), modes(jelly.modes(model)) {
        haptable_pair_init(&tables, &pair);
        haptable_modes_pair_init(&state);
    }
    void step(const Vector3d& first_m, const Vector3d& second_m) {
        const float at[2][3] = {{float(first_m.x()), float(first_m.y()), float(first_m.z())},
                                {float(second_m.x()), float(second_m.y()), float(second_m.z())}};
        haptable_modes_pair_step(&modes, &tables, &state, &pair, at, tick++ * 1000, out);
    }
    void step_alone(int finger, const Vector3d& at_m) {
        const float at[3] = {float(at_m.x()), float(at_m.y()), float(at_m.z())};
        haptable_modes_pair_step_finger(&modes, &tables, &state, &pair, finger, at, tick++ * 1000, &out[finger]);
    }
    Vector3d force(int finger) const { return to_vector(out[finger].force_n); }
    bool both_touch() const { return haptable_touches(out[0].state) && haptable_touches(out[1].state); }
    /// What is there: of the contacts what has been paid for.
    double all_j() const { return double(state.stored_j) - double(std::min(state.owed_j, state.contact_j)); }

    haptable_model model;
    haptable_pair_model tables;
    haptable_modes modes;
    haptable_pair pair{};
    haptable_modes_pair state{};
    haptable_output out[2]{};
    std::uint32_t tick = 0;
};

/// At nodes, for the interpolated force is exact there alone; and between them.
const Vector3d kAtNodes[2] = {{0.0075, 0.015, 0.03}, {0.0225, 0.015, 0.03}};
const Vector3d kOnTop[2] = {{0.0067, 0.0168, 0.03}, {0.0227, 0.0131, 0.03}};

/// Both down to `depth` at 20 mm/s, and for so long there.
void press(PairSession& session, const Vector3d at_m[2], double depth_m, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
        const Vector3d down(0, 0, std::max(-depth_m, 0.002 - 2e-5 * tick));
        session.step(at_m[0] + down, at_m[1] + 0.8 * down);
    }
}

/// S of both contacts, 6x6, of the consistent force, in double.
Eigen::Matrix<double, 6, 6> stiffness_of(const PairSession& session) {
    Eigen::Matrix<double, 6, 6> c;
    const haptable_contact* at[2] = {&session.pair.servo[0].contact, &session.pair.servo[1].contact};
    haptable_pair_own own;
    for (int f = 0; f < 2; ++f) {
        session.tables.law->own(&session.model, at[f], session.pair.servo[f].finger_m, &own);
        const float* a = own.a;
        c.block<3, 3>(3 * f, 3 * f) << a[0], a[3], a[5], a[3], a[1], a[4], a[5], a[4], a[2];
    }
    float block[9][9];
    session.tables.blocks(&session.tables, at[0]->patch, at[1]->patch, block);
    Eigen::Matrix3d x = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 9; ++k)
        x += double(at[0]->alpha[k / 3] * at[1]->alpha[k % 3]) *
             Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(block[k]).cast<double>();
    c.block<3, 3>(0, 3) = x;
    c.block<3, 3>(3, 0) = x.transpose();
    return c.inverse();
}

// Forces that are held come to those of the body without modes, at the same points of the surface, which friction
// keeps: L_rest and the modes make up L in all blocks of the pair.
TEST(ModesPair, ForcesThatAreHeldAreTheStaticOnes) {
    for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
        const Jelly ringing(for_two(force, 8)), still(for_two(force, 0));
        const Vector3d* at = force == ForceLaw::kInterpolated ? kAtNodes : kOnTop;
        PairSession session(ringing, GodObject::kNearest, 10.0);
        press(session, at, 0.003, 4000);
        ASSERT_TRUE(session.both_touch());
        const haptable_model whole = still.model(GodObject::kNearest, 10.0);
        for (const bool is_whole : {true, false}) {
            const haptable_pair_model of_whole = still.pair(whole);
            const haptable_pair_model& tables = is_whole ? of_whole : session.tables;
            haptable_pair pair;
            haptable_pair_init(&tables, &pair);
            float finger[2][3];
            haptable_output out[2];
            for (int f = 0; f < 2; ++f) {
                pair.servo[f] = session.pair.servo[f];
                std::copy_n(session.state.met[f].finger_m, 3, finger[f]);
            }
            haptable_pair_step(&tables, &pair, finger[0], finger[1], session.tick * 1000, out);
            for (int f = 0; f < 2; ++f) {
                const Vector3d wanted = to_vector(out[f].force_n);
                ASSERT_EQ(to_vector(out[f].god_object_m), to_vector(session.out[f].god_object_m));
                // What rings yet: exp(-0.05 omega t) of it; and the rest's tables are floats of which the modes are a
                // part.
                if (is_whole) {
                    EXPECT_LT((session.force(f) - wanted).norm(), 2e-5 * wanted.norm())
                        << "force " << static_cast<int>(force) << ", finger " << f;
                } else {
                    EXPECT_GT((session.force(f) - wanted).norm(), 0.05 * wanted.norm()) << "the modes are a part of it";
                }
            }
        }
    }
}

// One mode under two fingers that come and stay: omega_c^2 = omega^2 + phi . S phi of both, and the decay of the mode
// alone. A midpoint step is slow by (omega_c T)^2 / 12.
TEST(ModesPair, FingersThatStayFeelTheRing) {
    const Jelly ringing(for_two(ForceLaw::kConsistent, 1));
    PairSession session(ringing, GodObject::kNearest, 10.0);
    for (int tick = 0; tick < 4; ++tick)
        session.step(kAtNodes[0] + Vector3d(0.0, 0.0, 0.001), kAtNodes[1] + Vector3d(0.0, 0.0, 0.001));
    session.step(kAtNodes[0] - Vector3d(0, 0, 0.002), kAtNodes[1] - Vector3d(0, 0, 0.002));
    std::vector<double> force;
    for (int tick = 0; tick < 2000; ++tick) {
        const Vector3d away(0.001, 0.0, -0.002);  // sideways is where the lowest mode goes
        session.step(kAtNodes[0] + away, kAtNodes[1] + away);
        force.push_back(session.force(0).x() + session.force(1).x());
    }
    ASSERT_TRUE(session.both_touch());
    EXPECT_WITHIN(session.state.owed_j, .count = 8, .epsilon = kFloat, .size = session.all_j()) << "all is paid for";
    const double last = force.back();
    const double omega = ringing.files().omega_rad_per_s[0], zeta = 0.05;
    Eigen::Matrix<double, 6, 1> phi;
    for (int f = 0; f < 2; ++f) {
        const haptable_contact& contact = session.pair.servo[f].contact;
        phi.segment<3>(3 * f).setZero();
        for (int c = 0; c < 3; ++c) {
            const std::uint16_t vertex = session.model.patch[contact.patch][c];
            if (vertex < session.model.free_count)
                phi.segment<3>(3 * f) += double(contact.alpha[c]) * to_vector(session.modes.shape[vertex]);
        }
    }
    const Eigen::Matrix<double, 6, 6> s = stiffness_of(session);
    const double held = phi.dot(s * phi);
    const double alone =
        phi.head<3>().dot(s.block<3, 3>(0, 0) * phi.head<3>()) + phi.tail<3>().dot(s.block<3, 3>(3, 3) * phi.tail<3>());
    const double wanted = std::sqrt(omega * omega * (1.0 - zeta * zeta) + held);
    std::vector<double> crossing;  // upwards, through what it comes to
    for (std::size_t i = 1; i < 400; ++i)
        if (force[i - 1] < last && force[i] >= last)
            crossing.push_back(kTick * (double(i) - (force[i] - last) / (force[i] - force[i - 1])));
    ASSERT_GT(crossing.size(), 3U);
    const double period = (crossing.back() - crossing.front()) / double(crossing.size() - 1);
    const double within = (std::pow(wanted * kTick, 2.0) / 12.0 + 2e-3) * wanted;
    EXPECT_NEAR(2.0 * std::numbers::pi / period, wanted, within);
    EXPECT_GT(std::abs(std::sqrt(omega * omega + alone) - wanted), 2.0 * within) << "what couples them is seen";
    const auto most = [&](std::size_t from) {
        double size = 0.0;
        for (std::size_t i = from; i < from + 60; ++i) size = std::max(size, std::abs(force[i] - last));
        return size;
    };
    EXPECT_NEAR(std::log(most(0) / most(200)) / 0.2, zeta * omega, 0.1 * zeta * omega);
}

// Fingers that friction holds go to and fro by 10 um a tick: modes and contacts gain what they give, f . dx, and
// dx . S dx / 2 besides with the pair's S, but for what the modes' damping takes.
TEST(ModesPair, GainWhatTheHandsGave) {
    const Jelly& ringing = ringing_jelly(false);
    PairSession session(ringing, GodObject::kNearest, 10.0);
    press(session, kOnTop, 0.003, 400);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> part(-1e-5F, 1e-5F);
    Vector3d at[2] = {kOnTop[0] - Vector3d(0, 0, 0.003), kOnTop[1] - Vector3d(0, 0, 0.0024)};
    session.step(at[0], at[1]);
    const Eigen::Matrix<double, 6, 6> s = stiffness_of(session);
    double worst = 0.0, wall = 0.0;
    for (int tick = 0; tick < 500; ++tick) {
        const double before = session.all_j();
        Eigen::Matrix<double, 6, 1> load, moved;
        for (int f = 0; f < 2; ++f) {
            load.segment<3>(3 * f) = -session.force(f);
            moved.segment<3>(3 * f) = -to_vector(session.state.met[f].finger_m);
            at[f] += Vector3d(part(random), part(random), part(random));
        }
        session.step(at[0], at[1]);
        for (int f = 0; f < 2; ++f) moved.segment<3>(3 * f) += to_vector(session.state.met[f].finger_m);
        const double own = 0.5 * moved.dot(s * moved);
        worst = std::max(worst, std::abs(session.all_j() - before - load.dot(moved) - own));
        wall = std::max(wall, own);
    }
    ASSERT_TRUE(session.both_touch());
    // Energies are floats of some twenty terms; damping takes 2 zeta omega of the swing's share in a tick.
    const double omega = ringing.files().omega_rad_per_s.back();
    EXPECT_WITHIN(worst, .count = 16, .epsilon = kFloat,
                  .size = session.all_j() * (1.0 + 2e-4 * omega * kTick / kFloat / 16.0));
    EXPECT_LT(worst, 0.1 * wall) << "so that the wall's part is seen";
}

struct Found {
    double grown_j = 0.0, largest_j = 0.0, owed_j = 0.0;
    int lifted_ticks = 0;                  ///< of both, off the floor
    int contact_ticks = 0, low_ticks = 0;  ///< of both; with less than 0.9 of the force
};

/// Every second both hands want to be elsewhere: anywhere in the jelly and over it, or at opposite sides, in it.
Found play(const Jelly& ringing, GodObject god_object, double friction, std::uint32_t seed, int seconds) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> over(0.002, 0.028), height(0.018, 0.035);
    PairSession session(ringing, god_object, friction);
    Hand hand[2];
    for (int f = 0; f < 2; ++f) {
        hand[f].at_m = {0.01 + 0.01 * f, 0.015, 0.045};
        hand[f].damp(double(session.model.stiffness_limit_n_per_m));
    }
    Found found;
    double least = HUGE_VAL;
    for (int tick = 0; tick < 1000 * seconds; ++tick) {
        if (tick % 1000 == 0) {
            const bool squeeze = tick / 1000 % 3 == 1;
            const double deep = 0.1 * over(random), at = 0.7 * height(random);
            for (int f = 0; f < 2; ++f)
                hand[f].wants_m = squeeze ? Vector3d(f == 0 ? deep : 0.03 - deep, 0.015, at)
                                          : Vector3d(over(random), over(random), height(random));
            least = HUGE_VAL;  // wanting costs energy
        }
        session.step(hand[0].at_m, hand[1].at_m);
        const double all = hand[0].energy() + hand[1].energy() + session.all_j();
        const double contact = double(session.state.contact_j), owed = double(session.state.owed_j);
        // What the forces that were given have stored is what has been paid for.
        double work = 0.0, size = 0.0;
        for (int f = 0; f < 2; ++f) {
            if (!haptable_touches(session.out[f].state)) continue;
            const Vector3d at = to_vector(session.pair.servo[f].finger_m);
            work -= 0.5 * session.force(f).dot(at - to_vector(session.out[f].god_object_m));
            size += session.force(f).norm() * at.norm();
        }
        EXPECT_WITHIN(work - std::max(0.0, contact - owed), .count = 16, .epsilon = kFloat, .size = size + contact);
        found.contact_ticks += session.both_touch();
        found.low_ticks += session.both_touch() && owed > 0.1 * contact;
        found.owed_j = std::max(found.owed_j, owed);
        found.largest_j = std::max(found.largest_j, all);
        found.grown_j = std::max(found.grown_j, all - least);
        least = std::min(least, all);
        for (int f = 0; f < 2; ++f) hand[f].move(session.force(f));
    }
    return found;
}

TEST(ModesPair, EnergyNeverGrows) {
    const int sessions = asked("HAPTABLE_SESSIONS", 8), seconds = asked("HAPTABLE_SECONDS", 4);
    int contact_ticks = 0, low_ticks = 0;
    double owed_j = 0.0;
    for (int seed = 0; seed < sessions; ++seed) {
        const Found found = play(ringing_jelly(), seed / 2 % 2 == 0 ? GodObject::kLeastEnergy : GodObject::kNearest,
                                 seed % 2 == 0 ? 0.0 : 0.6, static_cast<std::uint32_t>(seed), seconds);
        // Floats that are summed anew in both ticks: 16 squares of modes, 12 products of each finger.
        EXPECT_WITHIN(found.grown_j, .count = 12, .epsilon = kFloat, .size = found.largest_j) << "session " << seed;
        contact_ticks += found.contact_ticks;
        low_ticks += found.low_ticks;
        owed_j = std::max(owed_j, found.owed_j);
    }
    EXPECT_GT(contact_ticks, 50 * sessions * seconds);
    EXPECT_GT(owed_j, 0.0) << "there was a debt";
    RecordProperty("owed_mj", std::to_string(1e3 * owed_j));
    RecordProperty("low", std::to_string(double(low_ticks) / contact_ticks));
}

// The paper's force has no energy of its own. What it makes as the fingers slide is taken out of the swing; as long as
// there is one no more is owed.
TEST(ModesPair, TheSwingPaysBeforeTheForcesDo) {
    Scene scene = for_two(ForceLaw::kInterpolated, 8);
    scene.vibration->damping_ratio = 1e-4;
    const Jelly ringing(scene);
    PairSession session(ringing, GodObject::kNearest);
    press(session, kOnTop, 0.005, 400);
    int taken = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const double before = session.all_j(), owed = double(session.state.owed_j);
        const Vector3d aside(0.004 * std::sin(0.005 * tick), 0.0, 0.0);
        session.step(kOnTop[0] + Vector3d(0, 0, -0.005) + aside, kOnTop[1] + Vector3d(0, 0, -0.004) - aside);
        const bool swings =
            std::any_of(session.state.swings.p, session.state.swings.p + 8, [](float p) { return p != 0.0F; });
        if (swings) {
            EXPECT_WITHIN(double(session.state.owed_j) - owed, .count = 16, .epsilon = kFloat, .size = before)
                << "tick " << tick;
        }
        taken += !swings;
    }
    EXPECT_GT(taken, 0) << "the force made something";
}

/// A jelly that nothing holds on a floor, and two fingers with friction or none.
struct FreeSession : PairSession {
    FreeSession(const Jelly& jelly, GodObject god_object, double friction) : PairSession(jelly, god_object, friction) {
        add_gravity(body);
        add_floor(body, 0.0, 0.5);
        begin();
    }
    /// It stands still, and nobody touches it.
    void begin() {
        haptable_body_init(&body, &where);
        haptable_pair_init(&tables, &pair);
        haptable_modes_pair_init(&state);
    }
    /// Up to the body's motion.
    void feel(const Vector3d& first_m, const Vector3d& second_m) {
        const float at[2][3] = {{float(first_m.x()), float(first_m.y()), float(first_m.z())},
                                {float(second_m.x()), float(second_m.y()), float(second_m.z())}};
        haptable_body_modes_pair_feel(&modes, &tables, &body, &where, &state, &pair, at, tick++ * 1000, push, out);
    }
    void move() { haptable_body_move(&body, &where, push, 2); }

    haptable_body body = cube_body();
    haptable_body_state where{};
    haptable_body_push push[2]{};
};

const Jelly& free_jelly() {
    static const Jelly made([] {
        Scene scene = jelly(ForceLaw::kConsistent, 8, true);
        scene.contact.fingers = 2;
        return scene;
    }());
    return made;
}

// Taken between two fingers, lifted, held for ten seconds, and let go: what the hands feel is its weight.
TEST(ModesPair, LiftAndHoldABodyThatNothingHolds) {
    FreeSession session(free_jelly(), GodObject::kLeastEnergy, 0.8);
    const auto hold = [&](double in, double up) {
        session.feel({in, 0.015, 0.02 + up}, {0.03 - in, 0.015, 0.02 + up});
        session.move();
    };
    for (int tick = 0; tick < 500; ++tick) hold(-0.002 + 0.007 * tick / 500.0, 0.0);
    for (int tick = 0; tick < 1000; ++tick) hold(0.005, 0.02 * tick / 1000.0);
    for (int tick = 0; tick < 10000; ++tick) hold(0.005, 0.02);
    const double weight = kMass_kg * 9.81;
    EXPECT_EQ(session.where.on_floor, 0);
    EXPECT_NEAR(-(session.force(0) + session.force(1)).z(), weight, 1e-3 * weight);
    const Vector3d held = position_of(session.where);
    Vector3d last = session.force(0);
    double buzz = 0.0;
    for (int tick = 0; tick < 1000; ++tick) {
        hold(0.005, 0.02);
        buzz = std::max(buzz, (session.force(0) - last).norm());
        last = session.force(0);
    }
    EXPECT_LT((position_of(session.where) - held).norm(), 1e-7);
    EXPECT_LT(buzz, 1e-5);
    for (int tick = 0; tick < 500; ++tick) hold(-0.005, 0.02);
    EXPECT_NE(session.where.on_floor, 0);
}

/// Both hands rest beside it.
void begin(Hand hand[2]) {
    for (int f = 0; f < 2; ++f) {
        hand[f].at_m = {f == 0 ? -0.01 : 0.04, 0.015, 0.018};
        hand[f].velocity.setZero();
    }
}

/// Every six seconds both hands go to its sides, squeeze, lift, part, and go anywhere twice.
Found play_free(GodObject god_object, double friction, std::uint32_t seed, int seconds) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    FreeSession session(free_jelly(), god_object, friction);
    Hand hand[2];
    begin(hand);
    for (int f = 0; f < 2; ++f) {
        hand[f].damp(double(session.model.stiffness_limit_n_per_m));
        if (seed % 2 == 0) hand[f].damping += 4.0;  // calm enough to lift it
    }
    Found found;
    double least = HUGE_VAL;
    for (int tick = 0; tick < 1000 * seconds; ++tick) {
        if (tick % 1000 == 0) {
            const int doing = tick / 1000 % 6;
            if ((position_of(session.where) - to_vector(session.body.centre_m)).norm() > 0.1) {  // it was knocked away
                session.begin();
                begin(hand);
            }
            const Vector3d centre = position_of(session.where);
            const double apart = doing == 0 || doing == 3 ? 0.022 : 0.008 + 0.002 * part(random);
            for (int f = 0; f < 2; ++f) {
                const Vector3d side(f == 0 ? -apart : apart, 0.0, doing == 2 ? 0.03 : 0.004);
                hand[f].wants_m =
                    centre + (doing < 4 ? side : Vector3d(0.02 * Vector3d(part(random), part(random), part(random))));
            }
            least = HUGE_VAL;  // wanting costs energy
        }
        session.feel(hand[0].at_m, hand[1].at_m);
        const double all =
            energy_of(session.body, session.where) + hand[0].energy() + hand[1].energy() + session.all_j();
        session.move();
        found.contact_ticks += session.both_touch();
        found.low_ticks += session.both_touch() && session.state.owed_j > 0.1F * session.state.contact_j;
        found.lifted_ticks += session.both_touch() && session.where.on_floor == 0;
        found.owed_j = std::max(found.owed_j, double(session.state.owed_j));
        found.largest_j = std::max(found.largest_j, all);
        found.grown_j = std::max(found.grown_j, all - least);
        least = std::min(least, all);
        for (int f = 0; f < 2; ++f) hand[f].move(session.force(f));
    }
    return found;
}

TEST(ModesPair, EnergyOfABodyThatNothingHoldsNeverGrows) {
    const int sessions = asked("HAPTABLE_SESSIONS", 8), seconds = asked("HAPTABLE_SECONDS", 6);
    Found all;
    for (int seed = 0; seed < sessions; ++seed) {
        const Found found = play_free(seed / 4 % 2 == 0 ? GodObject::kLeastEnergy : GodObject::kNearest,
                                      seed / 2 % 2 == 0 ? 0.8 : 0.0, static_cast<std::uint32_t>(seed), seconds);
        // Floats that are summed anew in both ticks: 16 squares of modes, 12 products of each finger.
        EXPECT_WITHIN(found.grown_j, .count = 12, .epsilon = kFloat, .size = found.largest_j) << "session " << seed;
        all.contact_ticks += found.contact_ticks;
        all.lifted_ticks += found.lifted_ticks;
        all.low_ticks += found.low_ticks;
        all.owed_j = std::max(all.owed_j, found.owed_j);
    }
    EXPECT_GT(all.contact_ticks, 50 * sessions * seconds);
    EXPECT_GT(all.lifted_ticks, 10 * sessions * seconds);
    EXPECT_GT(all.owed_j, 0.0) << "there was a debt";
    RecordProperty("owed_mj", std::to_string(1e3 * all.owed_j));
    RecordProperty("low", std::to_string(double(all.low_ticks) / all.contact_ticks));
}

// One finger alone on such a body does what haptable_body_modes_step does, to the bit, and either may be that one.
TEST(ModesPair, OneAlonePushesABodyThatNothingHolds) {
    for (int number = 0; number < 2; ++number) {
        FreeSession session(free_jelly(), GodObject::kLeastEnergy, 0.8);
        haptable_body_state where;
        haptable_body_init(&session.body, &where);
        haptable_servo servo;
        haptable_init(&servo);
        haptable_modes_state state;
        haptable_modes_init(&state);
        for (int tick = 0; tick < 400; ++tick) {
            const float at[3] = {0.0137F, 0.0168F, std::max(0.027F, 0.032F - 2e-5F * static_cast<float>(tick))};
            haptable_output out;
            haptable_body_modes_step(&session.modes, &session.body, &where, &state, &servo, at, session.tick * 1000,
                                     &out);
            haptable_body_modes_pair_step_finger(&session.modes, &session.tables, &session.body, &session.where,
                                                 &session.state, &session.pair, number, at, session.tick++ * 1000,
                                                 &session.out[number]);
            ASSERT_EQ(session.force(number), to_vector(out.force_n)) << tick;
            ASSERT_EQ(position_of(session.where), position_of(where)) << tick;
        }
        EXPECT_GT(session.force(number).norm(), 0.05);
        EXPECT_EQ(session.state.met[1 - number].patch, HAPTABLE_NONE);
    }
}

// A finger whose other is away is that of a scene with one, to the bit; and the other comes and goes.
TEST(ModesPair, OneAloneIsAsInASceneWithOne) {
    const Jelly& ringing = ringing_jelly();
    PairSession session(ringing, GodObject::kLeastEnergy);
    haptable_servo servo;
    haptable_init(&servo);
    haptable_modes_state state;
    haptable_modes_init(&state);
    haptable_output out;
    for (int tick = 0; tick < 3000; ++tick) {
        const Vector3d at =
            kOnTop[1] + Vector3d(1e-5 * std::min(tick, 400), 0.0, std::max(-0.003, 0.002 - 2e-5 * tick));
        const float finger[3] = {float(at.x()), float(at.y()), float(at.z())};
        haptable_modes_step(&session.modes, &state, &servo, finger, session.tick * 1000, &out);
        session.step_alone(1, at);
        ASSERT_EQ(session.force(1), to_vector(out.force_n)) << tick;
        ASSERT_EQ(session.state.swings.q[0], state.swings.q[0]) << tick;
    }
    ASSERT_TRUE(haptable_touches(out.state));
    const Vector3d alone = session.force(1), rests = to_vector(session.state.met[1].finger_m);
    for (int tick = 0; tick < 400; ++tick) session.step(kOnTop[0] + Vector3d(0, 0, 0.002 - 1e-5 * tick), rests);
    ASSERT_TRUE(session.both_touch());
    EXPECT_LT(session.force(1).norm(), 0.99 * alone.norm()) << "the other dents it away";
    haptable_init(&session.pair.servo[0]);
    for (int tick = 0; tick < 4000; ++tick) session.step_alone(1, rests);
    EXPECT_EQ(session.state.met[0].patch, HAPTABLE_NONE);
    EXPECT_NEAR(session.force(1).norm(), alone.norm(), 0.01 * alone.norm());
}

// A finger that is refused, or is no number, pushes nothing, and the other is felt on.
TEST(ModesPair, ARefusedFingerPushesNothing) {
    PairSession session(ringing_jelly(), GodObject::kLeastEnergy);
    press(session, kOnTop, 0.003, 1000);
    const Vector3d rests = kOnTop[1] - Vector3d(0, 0, 0.0024), before = session.force(1);
    for (int tick = 0; tick < 2000; ++tick) {
        session.step(Vector3d(tick % 2 == 0 ? NAN : 1e30, 0.0, 0.0), rests);
        EXPECT_EQ(session.force(0), Vector3d::Zero());
        ASSERT_TRUE(session.force(1).allFinite());
    }
    EXPECT_TRUE(haptable_touches(session.out[1].state));
    EXPECT_GT(session.force(1).norm(), 0.9 * before.norm());
}

}  // namespace
}  // namespace haptable::test
