// SPDX-License-Identifier: GPL-2.0-or-later
// A hand that touches a body that nothing holds.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bodies.hpp"
#include "tests/moving_body.hpp"
#include "tests/scene_session.hpp"

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

class BodyHandTest : public testing::Test {
protected:
    static const ElasticBody& cube() {
        static const ElasticBody cube(free_scene(), ForceLaw::kConsistent);
        return cube;
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

// What was refused, or is no number, leaves the body as if nobody touched it.
TEST_F(BodyHandTest, ARefusedFingerPushesNothing) {
    stand();
    const haptable_model model = cube().model(GodObject::kLeastEnergy);
    haptable_body_state alone;
    haptable_body_init(&body, &alone);
    SceneSession session(model, nullptr, &body, nullptr);
    for (int tick = 0; tick < 100; ++tick) {
        session.step(Vector3d(tick % 2 == 0 ? NAN : 1e30, 0.0, 0.0));
        haptable_body_move(&body, &alone);
        EXPECT_EQ(session.force().norm(), 0.0);
    }
    EXPECT_EQ(position_of(*session.state.body()), position_of(alone));
    EXPECT_EQ(to_vector(session.state.body()->velocity_m_per_s), to_vector(alone.velocity_m_per_s));
}

// A finger that presses the hanging cube moves it, and what it feels is what the suspension gives: action and reaction.
TEST_F(BodyHandTest, AFingerMovesTheBodyUntilItsSuspensionHolds) {
    hang();
    for (int c = 0; c < 3; ++c) {
        body.damping_n_s_per_m[c] = 0.5F;
        body.turn_damping_n_m_s[c] = 1e-4F;
    }
    const haptable_model model = cube().model(GodObject::kLeastEnergy);
    SceneSession session(model, nullptr, &body, nullptr);
    for (int tick = 0; tick < 4000; ++tick)
        session.step(Vector3d(0.015, 0.015, 0.03 + std::max(-0.008, 0.002 - 5e-6 * tick)));
    ASSERT_TRUE(session.touches());
    const double sunk = double(body.centre_m[2]) - position_of(*session.state.body()).z();
    EXPECT_GT(sunk, 0.004);
    EXPECT_NEAR(session.force().z(), double(body.stiffness_n_per_m[2]) * sunk, 1e-4 * session.force().z());
}

}  // namespace
}  // namespace haptable::test
