// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers on emulated microcontrollers: the host's bits, under their bound, and no more instructions than before.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "tests/bodies.hpp"
#include "tests/firmware/on_target.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// All pairs of the cube's top, or the whole cube in clusters.
const ElasticBody& body(ForceLaw force, std::uintmax_t coupling_bytes) {
    static std::map<std::pair<ForceLaw, std::uintmax_t>, std::unique_ptr<ElasticBody>> made;
    auto& one = made[{force, coupling_bytes}];
    if (!one)
        one = std::make_unique<ElasticBody>(for_two(cube_scene(5, 0.3, coupling_bytes == kAllPairs), coupling_bytes),
                                            force, coupling_bytes == kAllPairs ? 0.012 : 0.01);
    return *one;
}

struct PairCase {
    const char* target;
    Mode mode;
    std::uintmax_t coupling_bytes = kAllPairs;
};

std::vector<PairCase> pair_cases() {
    std::vector<PairCase> all;
    for (const Mode& mode : every_mode()) all.push_back({"cortex-m7", mode});
    for (const char* target : {"cortex-m4", "cortex-m33", "rv32"})
        for (const Mode& mode : {Mode{ForceLaw::kInterpolated, GodObject::kNearest, ""},
                                 Mode{ForceLaw::kPressureMask, GodObject::kLeastEnergy, ""},
                                 Mode{ForceLaw::kConsistent, GodObject::kLeastEnergy, "friction"}})
            all.push_back({target, mode});
    all.push_back({"cortex-m7", Mode{ForceLaw::kConsistent, GodObject::kLeastEnergy, ""}, 40'000});
    all.push_back({"cortex-m7", Mode{ForceLaw::kPressureMask, GodObject::kLeastEnergy, ""}, 60'000});
    all.push_back({"rv32", Mode{ForceLaw::kInterpolated, GodObject::kNearest, ""}, 40'000});
    return all;
}

std::string name_of_pair(const testing::TestParamInfo<PairCase>& info) {
    std::string name = std::string(info.param.target) + " " + info.param.mode.name();
    if (info.param.coupling_bytes != kAllPairs) name += " in clusters";
    return test_name(name);
}

class PairOnTarget : public testing::TestWithParam<PairCase> {};

INSTANTIATE_TEST_SUITE_P(Modes, PairOnTarget, testing::ValuesIn(pair_cases()), name_of_pair);

// At 168 MHz; docs/COSTS.md says which modes need a faster part.
TEST(PairBound, OfTheNearestGodObjectIsUnderNineTenthsOfAMillisecond) {
    for (const Mode& mode : every_mode())
        if (mode.god_object == GodObject::kNearest && mode.force != ForceLaw::kPressureMask &&
            mode.more != "friction") {
            EXPECT_LT(most_pair_cost(mode, 8), 168000U * 9 / 10) << mode.name();
        }
}

TEST_P(PairOnTarget, GivesTheHostsBitsUnderItsBound) {
    const PairCase& one = GetParam();
    const TargetImage image(build_folder(), "cube", one.target);
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const ElasticBody& touched = body(one.mode.force, one.coupling_bytes);
    const haptable_model model = in_mode(touched.model(), one.mode);
    Tables tables = touched.tables();
    const ServoPair coupling = build_pair(touched.pair(), tables, touched.servo());
    const haptable_pair_model pair_model = pair_in_memory(coupling, tables, model);
    ASSERT_EQ(pair_model.place_count > 0, one.coupling_bytes != kAllPairs);
    const auto path_m = of_two(hard_path(tables, 30), 30);
    const std::vector<TargetTick> ticks = image.measure({model, &pair_model}, path_m);
    const std::uint64_t fan = most_patches_around_a_vertex(model);
    const PairTickCost each = pair_cost_of(one.mode, fan);
    SceneState host(model, &pair_model, nullptr, nullptr);
    const haptable_pair& pair = *host.pair();
    std::size_t both = 0;
    std::uint64_t all = 0;
    double most = 0.0;
    expect_host_bits(ticks, host, path_m, [&](std::size_t i, const haptable_output out[]) {
        EXPECT_LE(pair.evaluations, HAPTABLE_PAIR_EVALUATIONS);
        EXPECT_LE(pair.looks, HAPTABLE_PAIR_LOOKS);
        if (one.coupling_bytes == kAllPairs) {
            most = std::max(most, double(ticks[i].instructions) / double(pair_cost(each, pair)));
            EXPECT_LE(ticks[i].instructions, pair_cost(each, pair));
            EXPECT_LT(ticks[i].instructions, most_pair_cost(one.mode, fan));
        }
        if (one.coupling_bytes != kAllPairs) most = std::max(most, double(ticks[i].instructions));
        both += haptable_touches(out[0].state) != 0 && haptable_touches(out[1].state) != 0;
        all += ticks[i].instructions;
    });
    EXPECT_GT(both, path_m.size() / 4);
    // One couples both contacts once a tick; with the rows of its controls for nobody it would take an eighth more.
    if (one.mode.name() == "interpolated nearest" && one.coupling_bytes == kAllPairs) {
        EXPECT_LT(all / path_m.size(), std::string(one.target) == "rv32" ? 4900U : 4300U);
    }
    RecordProperty(one.coupling_bytes == kAllPairs ? "of its bound" : "instructions", std::to_string(most));
}

}  // namespace
}  // namespace haptable::test
