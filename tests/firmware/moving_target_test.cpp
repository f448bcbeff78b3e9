// SPDX-License-Identifier: GPL-2.0-or-later
// Scenes on emulated microcontrollers: bodies that move, rigidly, in their modes and both, under one finger and two;
// three hands; a tool. The host's bits, under their bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codegen/loaded_scene.hpp"
#include "host/session/scene_state.hpp"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "tests/bodies.hpp"
#include "tests/firmware/on_target.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// A scene as `make images` leaves it, in memory.
struct Built {
    explicit Built(const std::string& name) : scene(TablesFolder(build_folder() / name)) {}
    SceneState state() const { return {scene.model(), scene.pair(), scene.body(), scene.modes(), scene.tool()}; }
    std::size_t fingers() const { return scene.pair() != nullptr ? scene.pair()->finger_count : 1; }
    /// What a tick's motion costs at the most beside its fingers' steps.
    std::uint64_t moves() const { return most_moving_cost(scene, mode); }
    /// The work of the fingers in the last tick, and at the most. Of more than two it is counted, without a bound.
    std::uint64_t touching(SceneState& state) const {
        if (fingers() > 2) return most_touching();
        return fingers() == 2 ? pair_cost(pair_cost_of(mode, fan), *state.pair())
                              : cost(cost_of(mode, fan), state.servo(0).counters);
    }
    std::uint64_t most_touching() const {
        if (fingers() > 2) return UINT64_MAX / 2;
        return fingers() == 2 ? most_pair_cost(mode, fan) : most_cost(mode, fan);
    }

    LoadedScene scene;
    Mode mode{scene.tables().force, scene.tables().god_object, "friction"};
    std::uint64_t fan = most_patches_around_a_vertex(scene.model());
};

class MovingTarget : public testing::TestWithParam<const char*> {
protected:
    /// Every tick of the path has the host's bits and stays under its bound. No test where there is no image.
    template <std::size_t size>
    void compare(const char* scene, const TargetPath<size>& path_m) {
        const TargetImage image(build_folder(), scene, GetParam());
        if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
        const Built built(scene);
        SceneState state = built.state();
        ticks = image.replay(path_m);
        state.check(HAPTABLE_CHECK_ALL);
        const std::uint64_t moves = built.moves(), most = built.most_touching();
        double nearest = 0.0;
        bool were_free = true;
        expect_host_bits(ticks, state, path_m, [&](std::size_t i, const haptable_output out[]) {
            bool are_free = true;
            for (std::size_t f = 0; f < built.fingers(); ++f)
                are_free &= out[f].state == HAPTABLE_FREE && state.servo(f).counters.most_boxes == 0;
            const std::uint64_t bound = built.touching(state) + moves;
            ASSERT_LE(ticks[i].instructions, bound);
            ASSERT_LT(ticks[i].instructions, most + moves);
            // Without fingers beside it the tick is the body's motion.
            if (are_free && were_free && moves > 0) {
                ASSERT_LE(ticks[i].instructions, moves);
            }
            were_free = are_free;
            nearest = std::max(nearest, double(ticks[i].instructions) / double(bound));
        });
        RecordProperty("of its bound", std::to_string(nearest));
    }

    /// After compare: whether there is something to look at.
    bool has_ticks() const { return !IsSkipped() && !HasFatalFailure() && !ticks.empty(); }
    std::size_t touching(std::size_t fingers) const {
        return static_cast<std::size_t>(
            std::count_if(ticks.begin(), ticks.end(), [&](const TargetTick& tick) { return tick.touches(fingers); }));
    }
    /// Of its centre, m.
    float height(const TargetTick& tick) const { return tick.position_m[2] - ticks.front().position_m[2]; }

    std::vector<TargetTick> ticks;
};

TEST_P(MovingTarget, ThreeHandsHaveTheHostsForces) {
    const TargetImage image(build_folder(), "three-hands", GetParam());
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const auto first_m = walked(stroke_path(read_tables(build_folder() / "three-hands"), 15));
    TargetPath<9> path_m(first_m.size() / 3);
    for (std::size_t i = 0; i < path_m.size(); ++i)
        for (std::size_t f = 0; f < 3; ++f) std::copy_n(first_m[i + f * path_m.size()].begin(), 3, &path_m[i][3 * f]);
    compare("three-hands", path_m);
    if (!has_ticks()) return;
    EXPECT_GT(touching(3), path_m.size() / 10);
    EXPECT_GT(ticks.back().instructions, 0U) << "they are counted";
}

TEST_P(MovingTarget, AToolHasTheHostsWrench) {
    const TargetImage image(build_folder(), "pressed-disc", GetParam());
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const Built built("pressed-disc");
    SceneState state = built.state();
    state.check(HAPTABLE_CHECK_ALL);
    const auto path_m = poses_of(walked(stroke_path(built.scene.tables(), 15)));
    const std::uint64_t bound =
        most_tool_cost({built.mode.force, built.mode.god_object, ""}, built.fan, built.scene.tool()->points.count);
    ticks = image.replay(path_m);
    std::size_t touched = 0, turned = 0;
    expect_host_wrench(ticks, state, path_m, [&](std::size_t i, const haptable_tool_output& out) {
        ASSERT_LE(ticks[i].instructions, bound) << "tick " << i;
        touched += static_cast<std::size_t>(haptable_touches(out.hand.state));
        turned += std::abs(out.torque_n_m[0]) > 1e-5F;
    });
    EXPECT_GT(touched, path_m.size() / 4);
    EXPECT_GT(turned, path_m.size() / 8);
}

TEST_P(MovingTarget, ACubeThatNothingHoldsTips) {
    compare("free-cube", tip_path());
    if (!has_ticks()) return;
    EXPECT_GT(touching(1), 100U);
    EXPECT_LT(ticks.back().turn[0], 0.999F);
}

TEST_P(MovingTarget, AJellyRingsUnderOneFingerAndUnderTwo) {
    for (const int fingers : {1, 2}) {
        SCOPED_TRACE(fingers);
        if (fingers == 1) compare("ringing", knock_path());
        if (fingers == 2) compare("squeezed", squeeze_path());
        if (!has_ticks()) return;
        EXPECT_GT(touching(std::size_t(fingers)), 100U * unsigned(fingers));
        EXPECT_NE(ticks.back().q[0], 0.0F);
    }
}

// With modes and without.
TEST_P(MovingTarget, TwoFingersLiftACubeAndLetItFall) {
    for (const char* scene : {"grasped", "wobbling"}) {
        SCOPED_TRACE(scene);
        compare(scene, grasp_path());
        if (!has_ticks()) return;
        float most_m = 0.0F;
        for (const TargetTick& tick : ticks) most_m = std::max(most_m, height(tick));
        EXPECT_GT(most_m, 0.015F) << "they lifted it";
        EXPECT_LT(height(ticks.back()), 0.005F) << "and let it fall";
    }
}

INSTANTIATE_TEST_SUITE_P(Targets, MovingTarget, testing::ValuesIn(kTargets),
                         [](const auto& target) { return test_name(target.param); });

}  // namespace
}  // namespace haptable::test
