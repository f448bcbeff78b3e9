// SPDX-License-Identifier: GPL-2.0-or-later
// A hand that touches a body that nothing holds: the energy of both and of the contact between them never grows.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/bodies.hpp"
#include "tests/hand.hpp"
#include "tests/moving_body.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

Scene free_scene() {
    Scene scene = cube_scene(5, 0.45);
    scene.fixed.clear();
    scene.free_body = FreeBody{};
    scene.free_body->density_kg_per_m3 = 1000.0;
    scene.device.max_force_n = 20.0;
    return scene;
}

/// What a session found.
struct Found {
    double grown_j = 0.0;    ///< most by which the energy of all was above its least so far
    double largest_j = 0.0;  ///< of all
    int contact_ticks = 0;
};

class BodyHandTest : public testing::Test {
protected:
    static const ElasticBody& cube() {
        static const ElasticBody cube(free_scene(), ForceLaw::kConsistent);
        return cube;
    }

    /// One hand pushes for so many seconds; every second it wants to be elsewhere, inside the cube or beside it.
    Found play(std::uint32_t seed, int seconds) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> over(-0.01, 0.04), part(-1.0, 1.0);
        haptable_body_state state;
        haptable_servo servo;
        haptable_body_init(&body, &state);
        haptable_init(&servo);
        const haptable_model model = cube().model(GodObject::kLeastEnergy);
        Hand hand;
        hand.at_m = {0.015, 0.015, 0.045};
        hand.damp(cube().servo().stiffness.felt_n_per_m);
        Found found;
        double least = HUGE_VAL;
        for (int tick = 0; tick < 1000 * seconds; ++tick) {
            if (tick % 1000 == 0) {
                // A cube that was knocked away is put back, so that there is something to touch.
                if ((position_of(state) - to_vector(body.centre_m)).norm() > 0.1) haptable_body_init(&body, &state);
                const Vector3d centre = position_of(state);
                hand.wants_m = centre + 0.02 * Vector3d(part(random), part(random), part(random));
                least = HUGE_VAL;  // wanting costs energy
            }
            const float finger[3] = {float(hand.at_m.x()), float(hand.at_m.y()), float(hand.at_m.z())};
            // As haptable_body_step does, with a look between what is taken back and the tick's motion.
            haptable_body_state whole = state;
            haptable_servo same = servo;
            float inside[3];
            haptable_output out;
            haptable_body_step(&model, &body, &whole, &same, 1, &finger, static_cast<std::uint32_t>(tick) * 1000, &out);
            haptable_body_push push;
            haptable_body_from_world(&body, &state, finger, inside);
            haptable_step(&model, &servo, inside, static_cast<std::uint32_t>(tick) * 1000, &out);
            const float made = haptable_body_push_of(&model, &body, &servo, &state, 0, finger, inside, &out, &push);
            haptable_body_brake(&body, &state, made);
            const double all = energy_of(body, state) + hand.energy() + double(state.stored_j[0]);
            haptable_body_move(&body, &state, &push, 1);
            EXPECT_EQ(to_vector(whole.velocity_m_per_s), to_vector(state.velocity_m_per_s)) << "tick " << tick;
            EXPECT_EQ(to_vector(whole.spin_rad_per_s), to_vector(state.spin_rad_per_s)) << "tick " << tick;
            found.contact_ticks += haptable_touches(out.state);
            found.largest_j = std::max(found.largest_j, all);
            found.grown_j = std::max(found.grown_j, all - least);
            least = std::min(least, all);
            hand.move(to_vector(state.given_n[0]));
        }
        return found;
    }

    /// On the floor, by its weight; or between springs, which do not damp.
    void stand() {
        add_gravity(body);
        add_floor(body, 0.0, 0.5);
    }
    void hang() {
        for (int c = 0; c < 3; ++c) {
            body.stiffness_n_per_m[c] = 3.0F;
            body.turn_stiffness_n_m[c] = 1e-3F;
        }
    }

    haptable_body body = cube_body();
};

TEST_F(BodyHandTest, EnergyNeverGrows) {
    const int sessions = asked("HAPTABLE_SESSIONS", 12), seconds = asked("HAPTABLE_SECONDS", 4);
    int contact_ticks = 0;
    for (int seed = 0; seed < sessions; ++seed) {
        body = cube_body();
        if (seed % 2 == 0)
            stand();
        else
            hang();
        const Found found = play(static_cast<std::uint32_t>(seed), seconds);
        // Its terms are floats that are summed anew each tick.
        EXPECT_WITHIN(found.grown_j, .count = 4, .epsilon = kFloat, .size = found.largest_j) << "session " << seed;
        contact_ticks += found.contact_ticks;
    }
    EXPECT_GT(contact_ticks, 20 * sessions * seconds);
}

// What was refused, or is no number, leaves the body as if nobody touched it.
TEST_F(BodyHandTest, ARefusedFingerPushesNothing) {
    stand();
    const haptable_model model = cube().model(GodObject::kLeastEnergy);
    haptable_body_state touched, alone;
    haptable_servo servo;
    haptable_body_init(&body, &touched);
    haptable_body_init(&body, &alone);
    haptable_init(&servo);
    for (int tick = 0; tick < 100; ++tick) {
        const float bad = tick % 2 == 0 ? NAN : 1e30F;
        const float finger[1][3] = {{bad, 0.0F, 0.0F}};
        haptable_output out;
        haptable_body_step(&model, &body, &touched, &servo, 1, finger, static_cast<std::uint32_t>(tick) * 1000, &out);
        haptable_body_move(&body, &alone, nullptr, 0);
        EXPECT_EQ(to_vector(out.force_n).norm(), 0.0);
    }
    EXPECT_EQ(position_of(touched), position_of(alone));
    EXPECT_EQ(to_vector(touched.velocity_m_per_s), to_vector(alone.velocity_m_per_s));
}

// A finger that presses the hanging cube moves it, and what it feels is what the suspension gives: action and reaction.
TEST_F(BodyHandTest, AFingerMovesTheBodyUntilItsSuspensionHolds) {
    hang();
    for (int c = 0; c < 3; ++c) {
        body.damping_n_s_per_m[c] = 0.5F;
        body.turn_damping_n_m_s[c] = 1e-4F;
    }
    const haptable_model model = cube().model(GodObject::kLeastEnergy);
    haptable_body_state state;
    haptable_servo servo;
    haptable_body_init(&body, &state);
    haptable_init(&servo);
    haptable_output out;
    for (int tick = 0; tick < 4000; ++tick) {
        const float down = std::max(-0.008F, 0.002F - 5e-6F * static_cast<float>(tick));
        const float finger[1][3] = {{0.015F, 0.015F, 0.03F + down}};
        haptable_body_step(&model, &body, &state, &servo, 1, finger, static_cast<std::uint32_t>(tick) * 1000, &out);
    }
    ASSERT_TRUE(haptable_touches(out.state));
    const double sunk = double(body.centre_m[2]) - position_of(state).z();
    EXPECT_GT(sunk, 0.004);
    EXPECT_NEAR(double(out.force_n[2]), double(body.stiffness_n_per_m[2]) * sunk, 1e-4 * double(out.force_n[2]));
}

}  // namespace
}  // namespace haptable::test
