// SPDX-License-Identifier: GPL-2.0-or-later
// Hands that go anywhere on a cube that is held, with the paper's god-object, which gives energy: with passivity they
// are given next to none, and nothing throws them about.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "tests/bodies.hpp"
#include "tests/hand.hpp"
#include "tests/scene_session.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr int kSeconds = 16;

class PassivityHands : public testing::TestWithParam<int> {
protected:
    int fingers() const { return GetParam(); }
    haptable_model model(bool is_passive) const {
        Tables tables = body_.tables();
        tables.options.set("contact.passivity", is_passive);
        return model_in_memory(tables, body_.servo());
    }
    /// J: the most that all hands were given since the session's begin, less what they gave.
    double most_given(const haptable_model& model, std::uint32_t seed) const {
        const haptable_pair_model tables = pair_in_memory(coupling_, body_.tables(), model);
        SceneSession session(model, fingers() == 2 ? &tables : nullptr, nullptr, nullptr);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> over(0.0, 0.03), height(0.01, 0.04);
        Hand hand[2];
        for (int f = 0; f < 2; ++f) {
            hand[f].damp(body_.servo().stiffness.felt_n_per_m);
            if (seed % 2 != 0) hand[f].damping += 4.0;  // a calm one comes to rest
            hand[f].at_m = hand[f].wants_m = {0.01 + 0.01 * f, 0.015, 0.045};
        }
        double given = 0.0, most = 0.0;
        for (std::uint32_t tick = 0; tick < 1000 * kSeconds; ++tick) {
            if (tick % 500 == 0)
                for (Hand& one : hand) one.wants_m = {over(random), over(random), height(random)};
            session.step(hand[0].at_m, fingers() == 2 ? std::optional(hand[1].at_m) : std::nullopt);
            for (int f = 0; f < fingers(); ++f) {
                const Vector3d from = hand[f].at_m, force = session.force(std::size_t(f));
                hand[f].move(force);
                given += force.dot(hand[f].at_m - from);
            }
            most = std::max(most, given);
        }
        return most;
    }

    const ElasticBody body_{[] {
                                Scene scene = cube_scene(5, 0.45);
                                scene.contact.fingers = 2;
                                scene.device.max_force_n = 20.0;
                                return scene;
                            }(),
                            ForceLaw::kConsistent};
    const ServoPair coupling_ = build_pair(body_.pair(), body_.tables(), body_.servo());
};

TEST_P(PassivityHands, GetNextToNothing) {
    const int sessions = asked("HAPTABLE_SESSIONS", 40);
    double without = 0.0, with = 0.0;
    for (int seed = 0; seed < sessions; ++seed) {
        without = std::max(without, most_given(model(false), static_cast<std::uint32_t>(seed)));
        with = std::max(with, most_given(model(true), static_cast<std::uint32_t>(seed)));
    }
    RecordProperty("given_j", std::to_string(with));
    EXPECT_GT(without, 1e-3);
    EXPECT_LT(with, 0.1 * without);
}

INSTANTIATE_TEST_SUITE_P(Fingers, PassivityHands, testing::Values(1, 2));

}  // namespace
}  // namespace haptable::test
