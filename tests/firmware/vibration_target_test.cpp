// SPDX-License-Identifier: GPL-2.0-or-later
// A body that rings on emulated microcontrollers: the host's bits.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "codegen/in_memory.hpp"
#include "codegen/vibration.hpp"
#include "host/target/image.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// Three knocks, a slide at depth, and what is no position.
std::vector<std::array<float, 3>> knock_path() {
    std::vector<std::array<float, 3>> path;
    for (int tick = 0; tick < 300; ++tick)
        path.push_back({0.0137F, 0.0168F, 0.029F + 0.003F * std::cos(0.063F * static_cast<float>(tick))});
    for (int tick = 0; tick < 300; ++tick)
        path.push_back({0.0137F + 2e-5F * static_cast<float>(tick), 0.0168F, 0.028F});
    path[450] = {NAN, 0.0F, 0.0F};
    return path;
}

class VibrationTarget : public testing::TestWithParam<const char*> {};

TEST_P(VibrationTarget, GivesTheBitsOfTheHost) {
    const TargetImage image(build_folder(), "ringing", GetParam());
    const auto folder = build_folder() / "ringing";
    if (!std::filesystem::exists(folder / "firmware" / GetParam() / "modes.elf"))
        GTEST_SKIP() << "no image for " << GetParam() << ": no cross compiler";
    const auto path = knock_path();
    const auto got = image.ring(path);
    ASSERT_EQ(got.size(), path.size());
    const Tables tables = read_tables(folder);
    const ServoModel built = build_model(tables);
    const haptable_model model = model_in_memory(tables, built);
    const ServoVibration vibration = build_vibration(*read_vibration(folder), tables, built);
    const haptable_modes modes = vibration_in_memory(vibration, model);
    haptable_servo servo;
    haptable_init(&servo);
    haptable_check(&model, &servo, HAPTABLE_CHECK_ALL);
    haptable_modes_state state;
    haptable_modes_init(&state);
    int contact_ticks = 0;
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        haptable_output out;
        haptable_modes_step(&modes, &state, &servo, path[tick].data(), static_cast<std::uint32_t>(tick) * 1000, &out);
        contact_ticks += haptable_touches(out.state);
        ASSERT_EQ(std::memcmp(got[tick].data(), out.force_n, sizeof out.force_n), 0) << "force, tick " << tick;
        ASSERT_EQ(std::memcmp(&got[tick][3], state.shift_m, sizeof state.shift_m), 0) << "shift, tick " << tick;
    }
    EXPECT_GT(contact_ticks, 100);
    EXPECT_NE(state.q[0], 0.0F);
}

INSTANTIATE_TEST_SUITE_P(Targets, VibrationTarget, testing::ValuesIn(kTargets), [](const auto& target) {
    std::string name = target.param;
    for (char& c : name) c = c == '-' ? '_' : c;
    return name;
});

}  // namespace
}  // namespace haptable::test
