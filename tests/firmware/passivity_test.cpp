// SPDX-License-Identifier: GPL-2.0-or-later
// Hands that go anywhere on a cube that is held, with the paper's god-object, which gives energy: with passivity they
// are given next to none, and nothing throws them about.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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
    SceneSession begin(const haptable_model& model, const haptable_pair_model& tables) const {
        return {model, fingers() == 2 ? &tables : nullptr, nullptr, nullptr};
    }
    /// J: the most that all hands were given since the session's begin, less what they gave.
    double most_given(const haptable_model& model, std::uint32_t seed) const {
        const haptable_pair_model tables = pair_in_memory(coupling_, body_.tables(), model);
        SceneSession session = begin(model, tables);
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

// Straight in and out; steps of 2^-14 m are exact in float32.
TEST_P(PassivityHands, TakeInTheNextTickWhatTheyWereGivenIfTheyGoOn) {
    constexpr int kTicks = 128;
    const haptable_model plain = model(false), passive = model(true);
    const haptable_pair_model tables = pair_in_memory(coupling_, body_.tables(), plain),
                              braked_tables = pair_in_memory(coupling_, body_.tables(), passive);
    SceneSession without = begin(plain, tables), with = begin(passive, braked_tables);
    double given = 0.0, most = 0.0;
    int braked = 0;
    for (int tick = 0; tick < 2 * kTicks; ++tick) {
        const Vector3d at_m(0.01171875, 0.015625, 0.03125 - std::ldexp(std::min(tick, 2 * kTicks - tick), -14));
        const std::optional<Vector3d> other =
            fingers() == 2 ? std::optional<Vector3d>(at_m + Vector3d(0.0078125, 0.0, 0.0)) : std::nullopt;
        without.step(at_m, other);
        with.step(at_m, other);
        double force_n = 0.0, braked_n = 0.0;
        for (std::size_t f = 0; f < std::size_t(fingers()); ++f) {
            force_n += without.force(f).z();
            braked_n += with.force(f).z();
        }
        const double motion_m = std::ldexp(tick < kTicks ? -1.0 : 1.0, -14), before = given;
        given += braked_n * motion_m;
        most = std::max(most, std::abs(given));
        if (tick <= kTicks || before <= 0.0 || force_n <= 0.0) continue;
        EXPECT_NEAR(given, force_n * motion_m, 4.0 * kTicks * std::ldexp(most, -24)) << tick;
        ++braked;
    }
    EXPECT_GT(braked, 3);
}

INSTANTIATE_TEST_SUITE_P(Fingers, PassivityHands, testing::Values(1, 2));

}  // namespace
}  // namespace haptable::test
