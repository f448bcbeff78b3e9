// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers with friction grasp a cube that stands on a floor, lift it, hold it, and let it go.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "tests/bodies.hpp"
#include "tests/moving_body.hpp"
#include "tests/scene_session.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kPress_m = 0.0025, kLift_m = 0.03;

class BodyGraspTest : public testing::Test {
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
                scene.device.max_force_n = 20.0;
                return scene;
            }(),
            ForceLaw::kConsistent);
        return cube;
    }

    BodyGraspTest() {
        add_gravity(body);
        add_floor(body, 0.0, 0.5);
        session.emplace(model, &pair_model, &body, nullptr);
    }
    /// Both fingers above the cube's middle, so that it hangs, and `in` deep in its sides, risen by `up`.
    void step(double in, double up) {
        session->step(Vector3d(in, 0.015, 0.02 + up), Vector3d(0.03 - in, 0.015, 0.02 + up));
    }
    const haptable_body_state& state() { return *session->state.body(); }
    double height() { return position_of(state()).z() - double(body.centre_m[2]); }

    Tables tables = cube().tables();
    haptable_model model = model_in_memory(tables, cube().servo());
    haptable_body body = cube_body();
    ServoPair coupling = build_pair(cube().pair(), cube().tables(), cube().servo());
    haptable_pair_model pair_model = pair_in_memory(coupling, tables, model);
    std::optional<SceneSession> session;
};

TEST_F(BodyGraspTest, LiftsHoldsAndDrops) {
    for (int tick = 0; tick < 500; ++tick) step(-0.002, 0.0);
    for (int tick = 0; tick < 500; ++tick) step(-0.002 + (0.002 + kPress_m) * tick / 500.0, 0.0);
    for (int tick = 0; tick < 1000; ++tick) step(kPress_m, kLift_m * tick / 1000.0);
    for (int tick = 0; tick < 10000; ++tick) step(kPress_m, kLift_m);
    EXPECT_EQ(state().on_floor, 0);
    EXPECT_GT(height(), kLift_m - 0.003);
    // What the hands feel is the cube's weight.
    const double weight = kMass_kg * 9.81;
    EXPECT_NEAR(-(session->force(0) + session->force(1)).z(), weight, 1e-3 * weight);

    const Vector3d held = position_of(state());
    const Eigen::Quaterniond turned = turn_of(state());
    Vector3d last[2] = {session->force(0), session->force(1)};
    double buzz = 0.0;
    for (int tick = 0; tick < 60000; ++tick) {
        step(kPress_m, kLift_m);
        for (std::size_t f = 0; f < 2; ++f) {
            buzz = std::max(buzz, (session->force(f) - last[f]).norm());
            last[f] = session->force(f);
        }
    }
    // Far below what a hand tells apart, 10 um and 10 mN; the spacing of floats is 4 nm and 30 nN here.
    EXPECT_LT((position_of(state()) - held).norm(), 1e-7);
    EXPECT_LT(turn_of(state()).angularDistance(turned), 1e-6);
    EXPECT_LT(buzz, 1e-5);

    for (int tick = 0; tick < 1000; ++tick) step(-0.002, kLift_m);
    EXPECT_NE(state().on_floor, 0);
    EXPECT_LT(height(), 1e-3);
}

}  // namespace
}  // namespace haptable::test
