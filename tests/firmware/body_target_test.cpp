// SPDX-License-Identifier: GPL-2.0-or-later
// A body that nothing holds on emulated microcontrollers: the host's bits.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "codegen/in_memory.hpp"
#include "codegen/rigid_body.hpp"
#include "host/target/image.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// Down onto the middle of the cube's top, and along it: friction tips it over an edge. Then what is no position.
std::vector<std::array<float, 3>> tip_path() {
    std::vector<std::array<float, 3>> path;
    for (int tick = 0; tick < 300; ++tick)
        path.push_back({0.015F, 0.0151F, 0.0325F - 2e-5F * static_cast<float>(tick)});
    for (int tick = 0; tick < 1000; ++tick)
        path.push_back({0.015F + 2e-5F * static_cast<float>(tick), 0.0151F, 0.0265F});
    path[1250] = {NAN, 0.0F, 0.0F};
    return path;
}

class BodyTarget : public testing::TestWithParam<const char*> {};

TEST_P(BodyTarget, GivesTheBitsOfTheHost) {
    const TargetImage image(build_folder(), "free-cube", GetParam());
    const auto folder = build_folder() / "free-cube";
    if (!std::filesystem::exists(folder / "firmware" / GetParam() / "body.elf"))
        GTEST_SKIP() << "no image for " << GetParam() << ": no cross compiler";
    const auto path = tip_path();
    const auto got = image.move_body(path);
    ASSERT_EQ(got.size(), path.size());
    const Tables tables = read_tables(folder);
    const ServoModel built = build_model(tables);
    const haptable_model model = model_in_memory(tables, built);
    const haptable_body body = *read_rigid_body(folder);
    haptable_servo servo;
    haptable_init(&servo);
    haptable_check(&model, &servo, HAPTABLE_CHECK_ALL);
    haptable_body_state state;
    haptable_body_init(&body, &state);
    int contact_ticks = 0;
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        const float finger[1][3] = {{path[tick][0], path[tick][1], path[tick][2]}};
        haptable_output out;
        haptable_body_step(&model, &body, &state, &servo, 1, finger, static_cast<std::uint32_t>(tick) * 1000, &out);
        contact_ticks += haptable_touches(out.state);
        ASSERT_EQ(std::memcmp(got[tick].data(), out.force_n, sizeof out.force_n), 0) << "force, tick " << tick;
        ASSERT_EQ(std::memcmp(&got[tick][3], state.position_m, sizeof state.position_m), 0) << "place, tick " << tick;
        ASSERT_EQ(std::memcmp(&got[tick][6], state.turn, sizeof state.turn), 0) << "turn, tick " << tick;
    }
    EXPECT_GT(contact_ticks, 100);
    EXPECT_LT(state.turn[0], 0.999F);
}

INSTANTIATE_TEST_SUITE_P(Targets, BodyTarget, testing::ValuesIn(kTargets), [](const auto& target) {
    std::string name = target.param;
    for (char& c : name) c = c == '-' ? '_' : c;
    return name;
});

}  // namespace
}  // namespace haptable::test
