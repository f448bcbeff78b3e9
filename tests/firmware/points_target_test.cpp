// SPDX-License-Identifier: GPL-2.0-or-later
// replay.elf of a tool and of three hands on emulated microcontrollers: the host's bits, counted, under the bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codegen/loaded_scene.hpp"
#include "host/session/scene_state.hpp"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "tests/firmware/on_target.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

class PointsReplay : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Targets, PointsReplay, testing::ValuesIn(kTargets),
                         [](const auto& target) { return test_name(target.param); });

TEST_P(PointsReplay, OfAToolHasTheHostsWrenchUnderItsBound) {
    const TargetImage image(build_folder(), "pressed-disc", GetParam());
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const LoadedScene scene{TablesFolder(build_folder() / "pressed-disc")};
    const auto path_m = poses_of(walked(stroke_path(scene.tables(), 15)));
    const auto ticks = image.replay(path_m);
    const std::uint64_t bound = most_tool_cost({scene.tables().force, scene.tables().god_object, ""},
                                               most_patches_around_a_vertex(scene.model()), scene.tool()->points.count);
    SceneState state(scene.model(), nullptr, nullptr, nullptr, scene.tool());
    state.check(HAPTABLE_CHECK_ALL);
    std::size_t touching = 0, turned = 0;
    std::uint64_t most = 0;
    for (std::size_t i = 0; i < path_m.size(); ++i) {
        haptable_tool_output out{};
        state.step(pose_of(path_m[i]), static_cast<std::uint32_t>(i * 1000), out);
        ASSERT_TRUE(same(ticks[i].finger[0], out.hand)) << "tick " << i;
        for (std::size_t a = 0; a < 3; ++a) ASSERT_EQ(ticks[i].q[a], out.torque_n_m[a]) << "tick " << i;
        EXPECT_GT(ticks[i].instructions, 0U);
        EXPECT_LE(ticks[i].instructions, bound);
        most = std::max(most, ticks[i].instructions);
        touching += static_cast<std::size_t>(haptable_touches(out.hand.state));
        turned += std::abs(out.torque_n_m[0]) > 1e-5F;
    }
    EXPECT_GT(touching, path_m.size() / 4);
    EXPECT_GT(turned, path_m.size() / 8);
    RecordProperty("most", std::to_string(most));
}

TEST_P(PointsReplay, OfThreeHandsHasTheHostsForces) {
    const TargetImage image(build_folder(), "three-hands", GetParam());
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const LoadedScene scene{TablesFolder(build_folder() / "three-hands")};
    const auto first_m = walked(stroke_path(scene.tables(), 15));
    const std::size_t part = first_m.size() / 3;
    TargetPath<9> path_m(part);
    for (std::size_t i = 0; i < part; ++i)
        for (std::size_t f = 0; f < 3; ++f) std::copy_n(first_m[i + f * part].begin(), 3, &path_m[i][3 * f]);
    const auto ticks = image.replay(path_m);
    SceneState state(scene.model(), scene.pair(), nullptr, nullptr);
    state.check(HAPTABLE_CHECK_ALL);
    std::size_t together = 0;
    for (std::size_t i = 0; i < part; ++i) {
        haptable_input in[3]{};
        haptable_output out[3]{};
        for (std::size_t f = 0; f < 3; ++f) {
            std::copy_n(&path_m[i][3 * f], 3, in[f].finger_m);
            in[f].is_there = 1;
        }
        state.step(in, static_cast<std::uint32_t>(i * 1000), out);
        for (std::size_t f = 0; f < 3; ++f)
            ASSERT_TRUE(same(ticks[i].finger[f], out[f])) << "tick " << i << " hand " << f;
        EXPECT_GT(ticks[i].instructions, 0U);
        together += ticks[i].touches(3);
    }
    EXPECT_GT(together, part / 10);
}

}  // namespace
}  // namespace haptable::test
