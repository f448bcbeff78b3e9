// SPDX-License-Identifier: GPL-2.0-or-later
// A body that rings on emulated microcontrollers: the host's bits, under their bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "codegen/vibration.hpp"
#include "firmware/haptable_modes_pair.h"
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
        ASSERT_EQ(std::memcmp(&got[tick].value[3], state.met.shift_m, sizeof state.met.shift_m), 0)
            << "shift, tick " << tick;
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
    EXPECT_NE(state.swings.q[0], 0.0F);
}

TEST_P(VibrationTarget, GivesTheBitsOfTheHostWithTwoFingers) {
    const TargetImage image(build_folder(), "squeezed", GetParam());
    const auto folder = build_folder() / "squeezed";
    if (!std::filesystem::exists(folder / "firmware" / GetParam() / "modes_pair.elf"))
        GTEST_SKIP() << "no image for " << GetParam() << ": no cross compiler";
    const auto path = squeeze_path();
    const auto got = image.ring_by_two(path);
    ASSERT_EQ(got.size(), path.size());
    const Tables tables = read_tables(folder);
    const ServoModel built = build_model(tables);
    const haptable_model model = model_in_memory(tables, built);
    const ServoPair coupling = build_pair(*read_pair(folder), tables, built);
    const haptable_pair_model coupled = pair_in_memory(coupling, tables, model);
    const ServoVibration vibration = build_vibration(*read_vibration(folder), tables, built);
    const haptable_modes modes = vibration_in_memory(vibration, model);
    haptable_pair pair;
    haptable_pair_init(&coupled, &pair);
    haptable_pair_check(&coupled, &pair, HAPTABLE_CHECK_ALL);
    haptable_modes_pair state;
    haptable_modes_pair_init(&state);
    const Mode mode{tables.force, tables.god_object, "friction"};
    const std::uint64_t fan = most_patches_around_a_vertex(model), rings = most_vibration_pair_cost(mode, modes.count);
    const PairTickCost each = pair_cost_of(mode, fan);
    int contact_ticks = 0;
    bool were_free = true;
    double most = 0.0;
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        const auto& at = path[tick];
        const float finger[2][3] = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}};
        haptable_output out[2];
        for (haptable_servo& one : pair.servo) {
            haptable_counters& done = one.counters;
            done.most_steps = done.most_held_steps = done.most_boxes = done.most_energies = 0;
        }
        haptable_modes_pair_step(&modes, &coupled, &state, &pair, finger, static_cast<std::uint32_t>(tick) * 1000, out);
        contact_ticks += haptable_touches(out[0].state) && haptable_touches(out[1].state);
        for (std::size_t f = 0; f < 2; ++f) {
            ASSERT_EQ(std::memcmp(&got[tick].value[3 * f], out[f].force_n, sizeof out[f].force_n), 0) << tick;
            ASSERT_EQ(std::memcmp(&got[tick].value[6 + 3 * f], state.met[f].shift_m, sizeof state.met[f].shift_m), 0)
                << tick;
        }
        const std::uint64_t bound = pair_cost(each, pair) + rings;
        ASSERT_LE(got[tick].instructions, bound) << "tick " << tick;
        ASSERT_LT(got[tick].instructions, most_pair_cost(mode, fan) + rings) << "tick " << tick;
        const bool are_free = out[0].state == HAPTABLE_FREE && out[1].state == HAPTABLE_FREE;
        if (are_free && were_free) {
            ASSERT_LE(got[tick].instructions, rings) << "tick " << tick;
        }
        were_free = are_free;
        most = std::max(most, double(got[tick].instructions) / double(bound));
    }
    RecordProperty("of its bound", std::to_string(most));
    EXPECT_GT(contact_ticks, 200);
    EXPECT_NE(state.swings.q[0], 0.0F);
}

INSTANTIATE_TEST_SUITE_P(Targets, VibrationTarget, testing::ValuesIn(kTargets), [](const auto& target) {
    std::string name = target.param;
    for (char& c : name) c = c == '-' ? '_' : c;
    return name;
});

}  // namespace
}  // namespace haptable::test
