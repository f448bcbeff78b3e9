// SPDX-License-Identifier: GPL-2.0-or-later
// A body that rings on emulated microcontrollers: the host's bits, under their bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "codegen/in_memory.hpp"
#include "codegen/vibration.hpp"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

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
    const Mode mode{tables.force, tables.god_object, "friction"};
    const std::uint64_t fan = most_patches_around_a_vertex(model), rings = most_vibration_cost(mode, modes.count);
    const TickCost each = cost_of(mode, fan);
    int contact_ticks = 0;
    double most = 0.0;
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        haptable_output out;
        haptable_counters& done = servo.counters;
        done.most_steps = done.most_held_steps = done.most_boxes = done.most_energies = 0;
        haptable_modes_step(&modes, &state, &servo, path[tick].data(), static_cast<std::uint32_t>(tick) * 1000, &out);
        contact_ticks += haptable_touches(out.state);
        ASSERT_EQ(std::memcmp(got[tick].value.data(), out.force_n, sizeof out.force_n), 0) << "force, tick " << tick;
        ASSERT_EQ(std::memcmp(&got[tick].value[3], state.shift_m, sizeof state.shift_m), 0) << "shift, tick " << tick;
        const std::uint64_t bound = cost(each, done) + rings;
        ASSERT_LE(got[tick].instructions, bound) << "tick " << tick;
        ASSERT_LT(got[tick].instructions, most_cost(mode, fan) + rings) << "tick " << tick;
        if (out.state == HAPTABLE_FREE) {
            ASSERT_LE(got[tick].instructions, rings) << "tick " << tick;
        }
        most = std::max(most, double(got[tick].instructions) / double(bound));
    }
    RecordProperty("of its bound", std::to_string(most));
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
