// SPDX-License-Identifier: GPL-2.0-or-later
// The servo on emulated microcontrollers: the host's bits, and no more instructions than before.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "codegen/in_memory.hpp"
#include "codegen/loaded_scene.hpp"
#include "host/target/counts.hpp"
#include "host/target/strokes.hpp"
#include "tests/bodies.hpp"
#include "tests/firmware/on_target.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

using Place = std::tuple<std::string, std::string>;  // scene, target

class Target : public testing::TestWithParam<Place> {
protected:
    const std::string scene = std::get<0>(GetParam());
    const std::string target = std::get<1>(GetParam());
    const TargetImage image{build_folder(), scene, target};

    Tables tables() const { return read_tables(build_folder() / scene); }
    /// What the body's own force takes, at any jump: without the limits, by the image that reads its model.
    std::vector<TargetTick> unlimited(const std::vector<std::array<float, 3>>& path_m) const {
        const LoadedScene bare(read_unlimited(build_folder() / scene));
        return TargetImage(build_folder(), "cube", target).measure({bare.model()}, path_m);
    }
};

std::string name_of_place(const testing::TestParamInfo<Place>& info) {
    return test_name(std::get<0>(info.param) + "_" + std::get<1>(info.param));
}

INSTANTIATE_TEST_SUITE_P(Scenes, Target,
                         testing::Combine(testing::Values(std::string("cube"), std::string("mouse")),
                                          testing::ValuesIn(std::vector<std::string>(kTargets.begin(),
                                                                                     kTargets.end()))),
                         name_of_place);

// Contact, edges, corners, misses, what is not a position or not to be believed, and the scene's limits on the force.
TEST_P(Target, GivesTheBitsOfTheHost) {
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const Tables host_tables = tables();
    auto path_m = walked(stroke_path(host_tables, 100));
    path_m[700] = {std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F};
    path_m[1500] = {0.0F, -std::numeric_limits<float>::infinity(), 0.0F};
    path_m[2300] = {0.0F, 0.0F, 1e30F};
    path_m[3000][2] += 0.025F;
    const ServoModel built = build_model(host_tables);
    const haptable_model model = model_in_memory(host_tables, built);
    SceneState host(model, nullptr, nullptr, nullptr);
    host.check(HAPTABLE_CHECK_ALL);
    expect_host_bits(image.replay(path_m), host, path_m, [](auto...) {});
    const haptable_counters& counters = host.servo(0).counters;
    EXPECT_GT(counters.contact_ticks, path_m.size() / 3);
    EXPECT_EQ(counters.rejected_positions, 3U);
    EXPECT_EQ(counters.implausible, 2U);
}

// Of which lab/cycles.py estimates the cycles.
TEST_P(Target, ATraceIsThatOfOneTick) {
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const auto path_m = walked(stroke_path(tables(), 10));
    const TickCounts counts = count_ticks(path_m, image.replay(path_m));
    const std::uint64_t median = counts.sliding.median;
    const std::size_t traced = image.trace(path_m, counts.sliding_at[0]).size();
    EXPECT_GE(traced, median);
    EXPECT_LE(traced, median + 2);  // and the marks' own
}

// Counts are exact, unlike times. Growth of more than 2 % in the median, 5 % in the worst, must be announced in
// instructions.txt. The median holds on every core: sliding costs the same on a small and a large mesh.
TEST_P(Target, TakesNoMoreInstructionsThanBefore) {
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const auto path_m = stroke_path(tables(), 100);
    const TickCounts counts = count_ticks(path_m, unlimited(path_m));
    // What instructions.txt wants, for whoever announces a change: --gtest_output=xml.
    RecordProperty("instructions", scene + " " + target + " " + std::to_string(counts.sliding.median) + " " +
                                       std::to_string(counts.sliding.worst) + " " +
                                       std::to_string(counts.first_contact.worst) + " " +
                                       std::to_string(counts.jump.worst));
    const std::vector<std::uint64_t> then = announced("instructions.txt", scene + " " + target + " ");
    ASSERT_EQ(then.size(), 4U);
    EXPECT_LE(counts.sliding.median, then[0] + then[0] / 50);
    EXPECT_LE(counts.sliding.worst, then[1] + then[1] / 20);
    EXPECT_LE(counts.first_contact.worst, then[2] + then[2] / 20);
    EXPECT_LE(counts.jump.worst, then[3] + then[3] / 20);
    EXPECT_LT(counts.sliding.median, 1500U);
    EXPECT_LT(counts.sliding.worst, 12000U);
}

// What the scene's limits, all but grab and ramp, add to a tick: they do not know the body.
TEST_P(Target, LimitsAddFewInstructions) {
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const auto path_m = walked(stroke_path(tables(), 100));
    const TickCounts with = count_ticks(path_m, image.replay(path_m)), bare = count_ticks(path_m, unlimited(path_m));
    RecordProperty("limits", scene + " " + target + " " + std::to_string(with.sliding.median) + " " +
                                 std::to_string(bare.sliding.median));
    EXPECT_LE(with.sliding.median, bare.sliding.median + 120);
    EXPECT_LE(with.sliding.worst, bare.sliding.worst + 400);
    EXPECT_LE(with.free.median, bare.free.median + 120);
}

}  // namespace
}  // namespace haptable::test
