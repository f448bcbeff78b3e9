// SPDX-License-Identifier: GPL-2.0-or-later
// modes under two fingers: forces that are held, the ring under both, and what modes and contacts gain.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numbers>
#include <random>

#include "firmware/haptable_scene.h"
#include "tests/jelly.hpp"
#include "tests/moving_body.hpp"
#include "tests/scene_session.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// The jelly of most tests; its damping is a ten thousandth, or 0.05.
const Jelly& ringing_jelly(bool is_damped = true) {
    static const Jelly damped(for_two(jelly(ForceLaw::kConsistent, 8)));
    static const Jelly undamped([] {
        Scene scene = for_two(jelly(ForceLaw::kConsistent, 8));
        scene.body_modes->damping_ratio = 1e-4;
        return scene;
    }());
    return is_damped ? damped : undamped;
}

/// What a session needs of a jelly.
struct PairParts {
    PairParts(const Jelly& jelly, GodObject god_object, double friction)
        : model(jelly.model(god_object, friction)), tables(jelly.pair(model, god_object)), modes(jelly.modes()) {}
    haptable_model model;
    haptable_pair_model tables;
    haptable_modes modes;
};

/// A jelly and two fingers; body: null where it is held.
struct PairSession : PairParts, SceneSession {
    PairSession(const Jelly& jelly, GodObject god_object, double friction = 0.0, const haptable_body* body = nullptr)
        : PairParts(jelly, god_object, friction), SceneSession(model, &tables, body, &modes) {}
    haptable_pair& pair() { return *state.pair(); }
    const haptable_past& past(int finger) const { return state.account().past[finger]; }
};

/// At nodes, for the interpolated force is exact there alone; and between them.
const Vector3d kAtNodes[2] = {{0.0075, 0.015, 0.03}, {0.0225, 0.015, 0.03}};
const Vector3d kBetweenNodes[2] = {{0.0067, 0.0168, 0.03}, {0.0227, 0.0131, 0.03}};

/// Both down to `depth` at 20 mm/s, and for so long there.
void press(PairSession& session, const Vector3d at_m[2], double depth_m, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
        const Vector3d down(0, 0, std::max(-depth_m, 0.002 - 2e-5 * tick));
        session.step(at_m[0] + down, at_m[1] + 0.8 * down);
    }
}

/// S of both contacts, 6x6, of the consistent force, in double.
Eigen::Matrix<double, 6, 6> stiffness_of(PairSession& session) {
    Eigen::Matrix<double, 6, 6> c;
    const haptable_contact* at[2] = {&session.pair().servo[0].contact, &session.pair().servo[1].contact};
    haptable_pair_own own;
    for (int f = 0; f < 2; ++f) {
        session.tables.law->own(&session.model, at[f], session.pair().servo[f].finger_m, &own);
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
    for (const ForceLaw force : every<ForceLaw>()) {
        const Jelly ringing(for_two(jelly(force, 8))), still(for_two(jelly(force, 0)));
        const Vector3d* at = force == ForceLaw::kInterpolated ? kAtNodes : kBetweenNodes;
        PairSession session(ringing, GodObject::kNearest, 10.0);
        press(session, at, 0.003, 4000);
        ASSERT_TRUE(session.both_touch());
        const haptable_model whole = still.model(GodObject::kNearest, 10.0);
        for (const bool is_whole : {true, false}) {
            const haptable_pair_model of_whole = still.pair(whole);
            const haptable_pair_model& tables = is_whole ? of_whole : session.tables;
            haptable_room room{};
            haptable_pair& pair = room.fingers;
            haptable_pair_init(&tables, &pair);
            float finger[2][3];
            haptable_output out[2];
            for (int f = 0; f < 2; ++f) {
                pair.servo[f] = session.pair().servo[f];
                std::copy_n(session.past(f).finger_m, 3, finger[f]);
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
    const Jelly ringing(for_two(jelly(ForceLaw::kConsistent, 1)));
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
    EXPECT_LE(session.state.account().owed_j, 0.0F) << "all is paid for";
    const double omega = ringing.files().omega_rad_per_s[0], zeta = 0.05;
    Eigen::Matrix<double, 6, 1> phi;
    for (int f = 0; f < 2; ++f) {
        const haptable_contact& contact = session.pair().servo[f].contact;
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
    const double within = expect_ring(force, wanted, zeta * omega);
    EXPECT_GT(std::abs(std::sqrt(omega * omega + alone) - wanted), 2.0 * within) << "what couples them is seen";
}

// Fingers that friction holds go to and fro by 10 um a tick: modes and contacts gain what they give, f . dx, and
// dx . S dx / 2 besides with the pair's S, but for what the modes' damping takes.
TEST(ModesPair, GainWhatTheHandsGave) {
    const Jelly& ringing = ringing_jelly(false);
    PairSession session(ringing, GodObject::kNearest, 10.0);
    press(session, kBetweenNodes, 0.003, 400);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> part(-1e-5F, 1e-5F);
    Vector3d at[2] = {kBetweenNodes[0] - Vector3d(0, 0, 0.003), kBetweenNodes[1] - Vector3d(0, 0, 0.0024)};
    session.step(at[0], at[1]);
    const Eigen::Matrix<double, 6, 6> s = stiffness_of(session);
    double worst = 0.0, wall = 0.0;
    for (int tick = 0; tick < 500; ++tick) {
        const double before = session.all_j();
        Eigen::Matrix<double, 6, 1> load, moved;
        for (int f = 0; f < 2; ++f) {
            load.segment<3>(3 * f) = -session.force(f);
            moved.segment<3>(3 * f) = -to_vector(session.past(f).finger_m);
            at[f] += Vector3d(part(random), part(random), part(random));
        }
        session.step(at[0], at[1]);
        for (int f = 0; f < 2; ++f) moved.segment<3>(3 * f) += to_vector(session.past(f).finger_m);
        const double own = 0.5 * moved.dot(s * moved);
        worst = std::max(worst, std::abs(session.all_j() - before - load.dot(moved) - own));
        wall = std::max(wall, own);
    }
    ASSERT_TRUE(session.both_touch());
    // Energies are floats of some twenty terms; damping takes 2 zeta omega of the swing's share in a tick.
    const double omega = ringing.files().omega_rad_per_s.back();
    EXPECT_WITHIN(worst, .count = 16, .epsilon = kFloat,
                  .size = session.all_j() * (1.0 + 2e-4 * omega * kTick_s / kFloat / 16.0));
    EXPECT_LT(worst, 0.1 * wall) << "so that the wall's part is seen";
}

haptable_body on_floor() {
    haptable_body body = cube_body();
    add_gravity(body);
    add_floor(body, 0.0, 0.5);
    return body;
}

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
    const haptable_body body = on_floor();
    PairSession session(free_jelly(), GodObject::kLeastEnergy, 0.8, &body);
    const auto hold = [&](double in, double up) {
        session.step(Vector3d(in, 0.015, 0.02 + up), Vector3d(0.03 - in, 0.015, 0.02 + up));
    };
    for (int tick = 0; tick < 500; ++tick) hold(-0.002 + 0.007 * tick / 500.0, 0.0);
    for (int tick = 0; tick < 1000; ++tick) hold(0.005, 0.02 * tick / 1000.0);
    for (int tick = 0; tick < 20000; ++tick) hold(0.005, 0.02);
    const double weight = kMass_kg * 9.81;
    EXPECT_EQ(session.state.body()->on_floor, 0);
    EXPECT_NEAR(-(session.force(0) + session.force(1)).z(), weight, 1e-3 * weight);
    const Vector3d held = position_of(*session.state.body());
    Vector3d last = session.force(0);
    double buzz = 0.0;
    for (int tick = 0; tick < 1000; ++tick) {
        hold(0.005, 0.02);
        buzz = std::max(buzz, (session.force(0) - last).norm());
        last = session.force(0);
    }
    EXPECT_LT((position_of(*session.state.body()) - held).norm(), 1e-7);
    EXPECT_LT(buzz, 1e-5);
    for (int tick = 0; tick < 500; ++tick) hold(-0.005, 0.02);
    EXPECT_NE(session.state.body()->on_floor, 0);
}

// One finger alone on such a body does what one does in a scene with one, to the bit, and either may be that one.
TEST(ModesPair, OneAlonePushesABodyThatNothingHolds) {
    const haptable_body body = on_floor();
    for (std::size_t number = 0; number < 2; ++number) {
        PairSession session(free_jelly(), GodObject::kLeastEnergy, 0.8, &body);
        SceneSession one(session.model, nullptr, &body, &session.modes);
        for (int tick = 0; tick < 400; ++tick) {
            const Vector3d at(0.0137, 0.0168, std::max(0.027, 0.032 - 2e-5 * tick));
            one.step(at);
            if (number == 0)
                session.step(at);
            else
                session.step({}, at);
            ASSERT_EQ(session.force(number), one.force()) << tick;
            ASSERT_EQ(position_of(*session.state.body()), position_of(*one.state.body())) << tick;
        }
        EXPECT_GT(session.force(number).norm(), 0.05);
    }
}

// A finger whose other is away is that of a scene with one, to the bit; and the other comes and goes.
TEST(ModesPair, OneAloneIsAsInASceneWithOne) {
    const Jelly& ringing = ringing_jelly();
    PairSession session(ringing, GodObject::kLeastEnergy);
    SceneSession one(session.model, nullptr, nullptr, &session.modes);
    Vector3d rests;
    for (int tick = 0; tick < 3000; ++tick) {
        rests = kBetweenNodes[1] + Vector3d(1e-5 * std::min(tick, 400), 0.0, std::max(-0.003, 0.002 - 2e-5 * tick));
        one.step(rests);
        session.step({}, rests);
        ASSERT_EQ(session.force(1), one.force()) << tick;
        ASSERT_EQ(session.state.modes()->q[0], one.state.modes()->q[0]) << tick;
    }
    ASSERT_TRUE(one.touches());
    const Vector3d alone = session.force(1);
    for (int tick = 0; tick < 400; ++tick) session.step(kBetweenNodes[0] + Vector3d(0, 0, 0.002 - 1e-5 * tick), rests);
    ASSERT_TRUE(session.both_touch());
    EXPECT_LT(session.force(1).norm(), 0.995 * alone.norm()) << "the other dents it away";
    for (int tick = 0; tick < 4000; ++tick) session.step({}, rests);
    EXPECT_NEAR(session.force(1).norm(), alone.norm(), 0.01 * alone.norm());
}

// A finger that is refused, or is no number, pushes nothing, and the other is felt on.
TEST(ModesPair, ARefusedFingerPushesNothing) {
    PairSession session(ringing_jelly(), GodObject::kLeastEnergy);
    press(session, kBetweenNodes, 0.003, 1000);
    const Vector3d rests = kBetweenNodes[1] - Vector3d(0, 0, 0.0024), before = session.force(1);
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
