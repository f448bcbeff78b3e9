// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers with friction grasp a cube that stands on a floor, lift it, hold it, and let it go.
#include <gtest/gtest.h>

#include <algorithm>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "firmware/haptable_body_pair.h"
#include "tests/bodies.hpp"
#include "tests/moving_body.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kPress_m = 0.0025, kLift_m = 0.03;

/// Whether the fingers feel one another's dents, or the body's motion alone.
class BodyGraspTest : public testing::TestWithParam<bool> {
protected:
    static const ElasticBody& cube() {
        static const ElasticBody cube(
            [] {
                Scene scene = cube_scene(5, 0.45);
                scene.fixed.clear();
                scene.free_body = FreeBody{};
                scene.free_body->density_kg_per_m3 = 1000.0;
                scene.contact.static_friction = scene.contact.kinetic_friction = 0.8;
                scene.contact.fingers = 2;
                return scene;
            }(),
            ForceLaw::kConsistent);
        return cube;
    }

    BodyGraspTest() {
        add_gravity(body);
        add_floor(body, 0.0, 0.5);
        haptable_body_init(&body, &state);
        for (haptable_servo& one : servo) haptable_init(&one);
        haptable_pair_init(&pair_model, &both);
    }
    /// Both fingers above the cube's middle, so that it hangs, and `in` deep in its sides, risen by `up`.
    void step(double in, double up) {
        const auto x = static_cast<float>(in), z = static_cast<float>(0.02 + up), y = 0.015F;
        const float finger[2][3] = {{x, y, z}, {0.03F - x, y, z}};
        now_us += 1000;
        if (GetParam())
            haptable_body_pair_step(&pair_model, &body, &state, &both, finger, now_us, out);
        else
            haptable_body_step(&model, &body, &state, servo, 2, finger, now_us, out);
    }
    double height() const { return position_of(state).z() - double(body.centre_m[2]); }

    haptable_model model = model_in_memory(cube().tables(), cube().servo());
    haptable_body body = cube_body();
    haptable_body_state state{};
    haptable_servo servo[2]{};
    ServoPair coupling = build_pair(cube().pair(), cube().tables(), cube().servo());
    haptable_pair_model pair_model = pair_in_memory(coupling, cube().tables(), model);
    haptable_pair both{};
    haptable_output out[2]{};
    std::uint32_t now_us = 0;
};

TEST_P(BodyGraspTest, LiftsHoldsAndDrops) {
    for (int tick = 0; tick < 500; ++tick) step(-0.002, 0.0);
    for (int tick = 0; tick < 500; ++tick) step(-0.002 + (0.002 + kPress_m) * tick / 500.0, 0.0);
    for (int tick = 0; tick < 1000; ++tick) step(kPress_m, kLift_m * tick / 1000.0);
    for (int tick = 0; tick < 5000; ++tick) step(kPress_m, kLift_m);
    EXPECT_EQ(state.on_floor, 0);
    EXPECT_GT(height(), kLift_m - 0.003);
    // What the hands feel is the cube's weight.
    const double weight = kMass_kg * 9.81;
    EXPECT_NEAR(-double(out[0].force_n[2] + out[1].force_n[2]), weight, 1e-3 * weight);

    const Vector3d held = position_of(state);
    const Eigen::Quaterniond turned = turn_of(state);
    Vector3d last[2] = {to_vector(out[0].force_n), to_vector(out[1].force_n)};
    double buzz = 0.0;
    for (int tick = 0; tick < 60000; ++tick) {
        step(kPress_m, kLift_m);
        for (int f = 0; f < 2; ++f) {
            buzz = std::max(buzz, (to_vector(out[f].force_n) - last[f]).norm());
            last[f] = to_vector(out[f].force_n);
        }
    }
    // Far below what a hand tells apart, 10 um and 10 mN; the spacing of floats is 4 nm and 30 nN here.
    EXPECT_LT((position_of(state) - held).norm(), 1e-7);
    EXPECT_LT(turn_of(state).angularDistance(turned), 1e-6);
    EXPECT_LT(buzz, 1e-5);

    for (int tick = 0; tick < 1000; ++tick) step(-0.002, kLift_m);
    EXPECT_NE(state.on_floor, 0);
    EXPECT_LT(height(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Fingers, BodyGraspTest, testing::Bool(),
                         [](const auto& coupled) { return coupled.param ? "coupled" : "alone"; });

}  // namespace
}  // namespace haptable::test
