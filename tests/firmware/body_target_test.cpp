// SPDX-License-Identifier: GPL-2.0-or-later
// A body that nothing holds on emulated microcontrollers, under one finger and two: the host's bits, under their bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "codegen/rigid_body.hpp"
#include "codegen/vibration.hpp"
#include "firmware/haptable_body_modes_pair.h"
#include "firmware/haptable_body_pair.h"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

/// A scene as `make images` leaves it, in memory.
struct Built {
    explicit Built(const std::string& name) : folder(build_folder() / name), tables(read_tables(folder)) {}

    std::filesystem::path folder;
    Tables tables;
    ServoModel servo = build_model(tables);
    haptable_model model = model_in_memory(tables, servo);
    haptable_body body = *read_rigid_body(folder);
    Mode mode{tables.force, tables.god_object, "friction"};
    std::uint64_t fan = most_patches_around_a_vertex(model);
};

void forget_work(haptable_counters& of) { of.most_steps = of.most_held_steps = of.most_boxes = of.most_energies = 0; }

/// The body is where the host has it, to the bit: `got` is centre and turn.
void expect_pose(const haptable_body_state& state, const float* got, std::size_t tick) {
    ASSERT_EQ(std::memcmp(got, state.position_m, sizeof state.position_m), 0) << "place, tick " << tick;
    ASSERT_EQ(std::memcmp(got + 3, state.turn, sizeof state.turn), 0) << "turn, tick " << tick;
}

class BodyTarget : public testing::TestWithParam<const char*> {
protected:
    static bool has_image(const char* scene, const char* elf) {
        return std::filesystem::exists(build_folder() / scene / "firmware" / GetParam() / elf);
    }
};

TEST_P(BodyTarget, GivesTheBitsOfTheHost) {
    if (!has_image("free-cube", "body.elf")) GTEST_SKIP() << "no image for " << GetParam() << ": no cross compiler";
    const Built built("free-cube");
    const auto path = tip_path();
    const auto got = TargetImage(build_folder(), "free-cube", GetParam()).move_body(path);
    const std::uint64_t moves = most_body_cost(built.body.point_count, 1);
    const TickCost each = cost_of(built.mode, built.fan);
    haptable_servo servo;
    haptable_init(&servo);
    haptable_check(&built.model, &servo, HAPTABLE_CHECK_ALL);
    haptable_body_state state;
    haptable_body_init(&built.body, &state);
    int contact_ticks = 0;
    double most = 0.0;
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        const float finger[1][3] = {{path[tick][0], path[tick][1], path[tick][2]}};
        haptable_output out;
        forget_work(servo.counters);
        haptable_body_step(&built.model, &built.body, &state, &servo, 1, finger,
                           static_cast<std::uint32_t>(tick) * 1000, &out);
        contact_ticks += haptable_touches(out.state);
        ASSERT_EQ(std::memcmp(got[tick].value.data(), out.force_n, sizeof out.force_n), 0) << "force, tick " << tick;
        ASSERT_NO_FATAL_FAILURE(expect_pose(state, &got[tick].value[3], tick));
        const std::uint64_t bound = cost(each, servo.counters) + moves;
        ASSERT_LE(got[tick].instructions, bound) << "tick " << tick;
        ASSERT_LT(got[tick].instructions, most_cost(built.mode, built.fan) + moves) << "tick " << tick;
        // Without a finger the tick is the body's motion.
        if (out.state != HAPTABLE_FREE) continue;
        ASSERT_LE(got[tick].instructions, moves) << "tick " << tick;
        most = std::max(most, double(got[tick].instructions) / double(moves));
    }
    EXPECT_GT(contact_ticks, 100);
    EXPECT_LT(state.turn[0], 0.999F);
    RecordProperty("of its bound", std::to_string(most));
}

TEST_P(BodyTarget, GivesTheBitsOfTheHostWithTwoFingers) {
    if (!has_image("grasped", "grasp.elf")) GTEST_SKIP() << "no image for " << GetParam() << ": no cross compiler";
    const Built built("grasped");
    const ServoPair coupling = build_pair(*read_pair(built.folder), built.tables, built.servo);
    const haptable_pair_model tables = pair_in_memory(coupling, built.tables, built.model);
    const auto path = grasp_path();
    const auto got = TargetImage(build_folder(), "grasped", GetParam()).move_body_by_two(path);
    const std::uint64_t moves = most_body_cost(built.body.point_count, 2);
    const PairTickCost each = pair_cost_of(built.mode, built.fan);
    haptable_pair pair;
    haptable_pair_init(&tables, &pair);
    haptable_pair_check(&tables, &pair, HAPTABLE_CHECK_ALL);
    haptable_body_state state;
    haptable_body_init(&built.body, &state);
    float highest_m = 0.0F;
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        const auto& at = path[tick];
        const float finger[2][3] = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}};
        haptable_output out[2];
        for (haptable_servo& one : pair.servo) forget_work(one.counters);
        haptable_body_pair_step(&tables, &built.body, &state, &pair, finger, static_cast<std::uint32_t>(tick) * 1000,
                                out);
        for (std::size_t f = 0; f < 2; ++f)
            ASSERT_EQ(std::memcmp(&got[tick].value[3 * f], out[f].force_n, sizeof out[f].force_n), 0)
                << "force, tick " << tick;
        ASSERT_NO_FATAL_FAILURE(expect_pose(state, &got[tick].value[6], tick));
        ASSERT_LE(got[tick].instructions, pair_cost(each, pair) + moves) << "tick " << tick;
        ASSERT_LT(got[tick].instructions, most_pair_cost(built.mode, built.fan) + moves) << "tick " << tick;
        if (tick < 100) {  // both wait beside it
            ASSERT_LE(got[tick].instructions, moves) << "tick " << tick;
        }
        highest_m = std::max(highest_m, state.position_m[2] - built.body.centre_m[2]);
    }
    EXPECT_GT(highest_m, 0.015F) << "they lifted it";
    EXPECT_LT(state.position_m[2] - built.body.centre_m[2], 0.005F) << "and let it fall";
}

TEST_P(BodyTarget, GivesTheBitsOfTheHostOfOneThatRings) {
    if (!has_image("wobbling", "grasp_modes.elf"))
        GTEST_SKIP() << "no image for " << GetParam() << ": no cross compiler";
    const Built built("wobbling");
    const ServoPair coupling = build_pair(*read_pair(built.folder), built.tables, built.servo);
    const haptable_pair_model tables = pair_in_memory(coupling, built.tables, built.model);
    const auto path = grasp_path();
    const auto got = TargetImage(build_folder(), "wobbling", GetParam()).move_ringing_body_by_two(path);
    const std::uint64_t moves = most_body_cost(built.body.point_count, 2) +
                                most_vibration_pair_cost(built.mode, read_vibration(built.folder)->modes());
    const PairTickCost each = pair_cost_of(built.mode, built.fan);
    const ServoVibration vibration = build_vibration(*read_vibration(built.folder), built.tables, built.servo);
    const haptable_modes modes = vibration_in_memory(vibration, built.model);
    haptable_modes_pair swings;
    haptable_modes_pair_init(&swings);
    haptable_pair pair;
    haptable_pair_init(&tables, &pair);
    haptable_pair_check(&tables, &pair, HAPTABLE_CHECK_ALL);
    haptable_body_state state;
    haptable_body_init(&built.body, &state);
    float highest_m = 0.0F;
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        const auto& at = path[tick];
        const float finger[2][3] = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}};
        haptable_output out[2];
        for (haptable_servo& one : pair.servo) forget_work(one.counters);
        haptable_body_modes_pair_step(&modes, &tables, &built.body, &state, &swings, &pair, finger,
                                      static_cast<std::uint32_t>(tick) * 1000, out);
        for (std::size_t f = 0; f < 2; ++f)
            ASSERT_EQ(std::memcmp(&got[tick].value[3 * f], out[f].force_n, sizeof out[f].force_n), 0)
                << "force, tick " << tick;
        ASSERT_NO_FATAL_FAILURE(expect_pose(state, &got[tick].value[6], tick));
        ASSERT_LE(got[tick].instructions, pair_cost(each, pair) + moves) << "tick " << tick;
        ASSERT_LT(got[tick].instructions, most_pair_cost(built.mode, built.fan) + moves) << "tick " << tick;
        if (tick < 100) {  // both wait beside it
            ASSERT_LE(got[tick].instructions, moves) << "tick " << tick;
        }
        highest_m = std::max(highest_m, state.position_m[2] - built.body.centre_m[2]);
    }
    EXPECT_GT(highest_m, 0.015F) << "they lifted it";
    EXPECT_LT(state.position_m[2] - built.body.centre_m[2], 0.005F) << "and let it fall";
}

INSTANTIATE_TEST_SUITE_P(Targets, BodyTarget, testing::ValuesIn(kTargets), [](const auto& target) {
    std::string name = target.param;
    for (char& c : name) c = c == '-' ? '_' : c;
    return name;
});

}  // namespace
}  // namespace haptable::test
