// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/precision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codegen/codegen.hpp"
#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

/// The shape's tables with blocks stored as `precision`.
struct Stored {
    Stored(const TestModel& from, Storage precision) : tables(from.tables()) {
        tables.precision = precision;
        servo = build_model(tables);
        model = model_in_memory(tables, servo);
    }
    Tables tables;
    ServoModel servo;
    haptable_model model{};
};

/// binary16 by its definition, with pow: shares nothing with the firmware's bit moves.
double half_value(std::uint16_t bits) {
    const int exponent = bits >> 10 & 31, fraction = bits & 1023;
    const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
    return (bits & 0x8000) != 0 ? -size : size;
}

TEST(Precision, EveryFiniteHalfIsWidenedExactly) {
    const TestModel box(box_shape(1, {1, 1, 1}));
    Stored stored(box, Storage::kFloat16);
    const float one = 1.0F;
    stored.model.packed_scale_n_per_m = &one;
    for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
        if ((bits & 0x7c00) == 0x7c00) continue;  // infinities and NaN, which codegen never writes
        const std::uint16_t block[1][6] = {{static_cast<std::uint16_t>(bits), 0, 0, 0, 0, 0}};
        stored.model.packed = block;
        float s[6];
        haptable_unpack_float16(&stored.model, 0, s);
        ASSERT_EQ(static_cast<double>(s[0]), half_value(block[0][0])) << bits;
    }
}

TEST(Precision, BlocksComeBackToWithinHalfAStep) {
    const TestModel ball(sphere_shape(2, 0.05));
    const Stored exact(ball, Storage::kFloat32), half(ball, Storage::kFloat16), whole(ball, Storage::kInt16);
    for (std::uint16_t v = 0; v < exact.model.free_count; ++v) {
        const float* s = exact.model.stiffness_n_per_m[v];
        float from_half[6], from_int[6], largest = 0.0F;
        half.model.unpack(&half.model, v, from_half);
        whole.model.unpack(&whole.model, v, from_int);
        for (int i = 0; i < 6; ++i) largest = std::max(largest, std::abs(s[i]));
        for (int i = 0; i < 6; ++i) {
            EXPECT_LE(std::abs(from_half[i] - s[i]), std::max(std::abs(s[i]) * 0x1p-11F, largest * 0x1p-24F));
            EXPECT_LE(std::abs(from_int[i] - s[i]), largest / 32767.0F * 0.5001F);
        }
    }
    EXPECT_EQ(half.model.stiffness_n_per_m == nullptr || half.model.unpack != nullptr, true);
}

/// The stated worst error holds for the servo itself, at random points and directions, and is nearly reached.
TEST(Precision, TheStatedErrorIsAnUpperBoundOfTheServosForce) {
    const TestModel ball(sphere_shape(2, 0.05));
    const auto stated = compare_precisions(ball.tables(), ball.servo());
    ASSERT_EQ(stated.size(), 3U);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    for (const PrecisionError& error : stated) {
        const Stored stored(ball, error.precision);
        double worst = 0.0;
        for (int trial = 0; trial < 20000; ++trial) {
            haptable_contact contact{};
            contact.patch = static_cast<std::uint16_t>(random() % stored.model.patch_count);
            contact.alpha[trial % 3] = 1.0F;  // a corner: the servo's own rounding stays small
            const float u[3] = {unit(random), unit(random), unit(random)};
            float nodal[3][3], force[3];
            haptable_force_interpolated(&stored.model, &contact, u, nodal, force);
            const std::uint16_t v = stored.model.patch[contact.patch][trial % 3];
            const Eigen::Vector3d exact = -ball.stiffness(v) * Eigen::Vector3d(u[0], u[1], u[2]);
            worst = std::max(worst, (Eigen::Vector3d(force[0], force[1], force[2]) - exact).norm() / exact.norm());
        }
        EXPECT_WITHIN(worst - error.worst, .count = 16, .epsilon = kFloat) << error.precision;
        EXPECT_GE(worst, 0.3 * error.worst) << error.precision;
    }
    // A block's rounding is of its largest number, or of the table's; S_d^-1 magnifies it by its condition.
    EXPECT_WITHIN(stated[0].worst, .count = 4, .epsilon = kFloat, .condition = 10.0);
    EXPECT_WITHIN(stated[1].worst, .count = 4, .epsilon = kHalf, .condition = 10.0);
    EXPECT_WITHIN(stated[2].worst, .count = 4, .epsilon = 0x1p-16, .condition = 10.0);
    EXPECT_EQ(stated[1].bytes, stated[0].bytes / 2 + 4);
}

TEST(Precision, TheServoTakesPackedTablesThroughAWholeStep) {
    const TestModel ball(sphere_shape(3, 0.05));
    const Stored exact(ball, Storage::kFloat32), packed(ball, Storage::kInt16);
    haptable_servo a, b;
    haptable_init(&a);
    haptable_init(&b);
    for (std::uint32_t tick = 0; tick < 200; ++tick) {
        const float finger[3] = {0.002F, 0.003F, 0.055F - 0.0001F * static_cast<float>(tick)};
        haptable_output one, other;
        haptable_step(&exact.model, &a, finger, 1000 * tick, &one);
        haptable_step(&packed.model, &b, finger, 1000 * tick, &other);
        ASSERT_EQ(one.state, other.state);
        ASSERT_EQ(one.patch, other.patch);
        for (int k = 0; k < 3; ++k)
            EXPECT_WITHIN(std::abs(one.force_n[k] - other.force_n[k]), .count = 16, .epsilon = 0x1p-16,
                          .size = double(std::abs(one.force_n[2])) + 1e-6);
    }
    EXPECT_EQ(a.state, HAPTABLE_CONTACT);
}

TEST(Precision, ABudgetThatIsTooSmallSaysWhatTakesTheRoomAndWhatWouldFit) {
    const TestModel ball(sphere_shape(3, 0.05));
    const auto tables = flash_tables(ball.servo());
    const std::size_t bytes = flash_bytes(ball.servo());
    const auto said = [&](std::uintmax_t budget) -> std::string {
        try {
            require_flash(tables, ball.servo(), budget);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(said(0), "");
    EXPECT_EQ(said(bytes), "");
    EXPECT_NE(said(bytes - 1).find("precision = \"float16\" takes"), std::string::npos) << said(bytes - 1);
    EXPECT_NE(said(bytes / 4).find("patches would fit"), std::string::npos) << said(bytes / 4);
    EXPECT_NE(said(bytes / 4).find("box "), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
