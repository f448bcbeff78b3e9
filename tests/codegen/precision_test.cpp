// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/precision.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "codegen/codegen.hpp"
#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"
#include "host/body/mask.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

/// Tables with blocks stored as `precision`.
struct Stored {
    Stored(const Tables& from, Storage precision) : tables(from) {
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
    Stored stored(box.tables(), Storage::kFloat16);
    const float one = 1.0F;
    stored.model.packed_scale = &one;
    for (std::uint32_t bits = 0; bits < 0x10000; ++bits) {
        if ((bits & 0x7c00) == 0x7c00) continue;  // infinities and NaN, which codegen never writes
        const std::uint16_t block[1][6] = {{static_cast<std::uint16_t>(bits), 0, 0, 0, 0, 0}};
        stored.model.packed = block;
        float s[6];
        haptable_unpack_float16(&stored.model, 0, s);
        ASSERT_EQ(static_cast<double>(s[0]), half_value(block[0][0])) << bits;
    }
}

// Some vertices are held and have no block: what lies behind the blocks is not the tables'.
TEST(Precision, TheCheckEndsWithThePackedTables) {
    const TestModel box(box_shape(3, {0.03, 0.03, 0.03}), 0.001);
    for (const Storage precision : {Storage::kFloat16, Storage::kInt16}) {
        const Stored stored(box.tables(), precision);
        ASSERT_LT(stored.model.free_count, stored.model.vertex_count);
        std::map<const void*, std::size_t> bytes_at;
        for (std::uint32_t field = 0;; ++field) {
            const haptable_span of = haptable_span_of_model(&stored.model, field);
            if (of.bytes == HAPTABLE_SPAN_END) break;
            bytes_at[of.at] = of.bytes;
        }
        const auto& blocks = stored.servo.packed;
        const auto& scales = stored.servo.packed_scale;
        EXPECT_EQ(bytes_at.at(blocks.data()), blocks.size() * sizeof blocks[0]);
        EXPECT_EQ(bytes_at.at(scales.data()), scales.size() * sizeof scales[0]);
    }
}

TEST(Precision, BlocksComeBackToWithinHalfAStep) {
    const Tables ball = TestModel(sphere_shape(2, 0.05)).tables();
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
}

Eigen::Vector3d force_at(const haptable_model& model, std::uint16_t patch, const std::array<float, 3>& alpha,
                         const Eigen::Vector3f& u) {
    haptable_contact contact{};
    contact.patch = patch;
    std::copy(alpha.begin(), alpha.end(), contact.alpha);
    return test::force_at(model, contact, u.cast<double>());
}

/// What is stated of float32, float16 and int16, and what that saves. A block's rounding is of its largest number, or
/// of the table's; the inverse that a force takes magnifies it by its condition.
std::vector<PrecisionError> stated_of(const Tables& tables, double condition) {
    auto stated = compare_precisions(tables, build_model(tables));
    EXPECT_EQ(stated.size(), 3U);
    EXPECT_WITHIN(stated[0].worst, .count = 4, .epsilon = kFloat, .condition = condition);
    EXPECT_WITHIN(stated[1].worst, .count = 4, .epsilon = kHalf, .condition = condition);
    EXPECT_WITHIN(stated[2].worst, .count = 4, .epsilon = 0x1p-16, .condition = condition);
    EXPECT_EQ(stated[1].bytes, stated[0].bytes / 2 + 4);
    return stated;
}

/// The stated worst error holds for the servo itself, at random points and directions, and is nearly reached.
TEST(Precision, TheStatedErrorIsAnUpperBoundOfTheServosForce) {
    const TestModel ball(sphere_shape(2, 0.05));
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    for (const PrecisionError& error : stated_of(ball.tables(), 10.0)) {
        const Stored stored(ball.tables(), error.precision);
        double worst = 0.0;
        for (int trial = 0; trial < 20000; ++trial) {
            const auto patch = std::uint16_t(random() % stored.model.patch_count);
            std::array<float, 3> alpha{};
            alpha[std::size_t(trial % 3)] = 1.0F;  // a corner: the servo's own rounding stays small
            const Eigen::Vector3f u(unit(random), unit(random), unit(random));
            const Eigen::Vector3d exact = -ball.stiffness(stored.model.patch[patch][trial % 3]) * u.cast<double>();
            worst = std::max(worst, (force_at(stored.model, patch, alpha, u) - exact).norm() / exact.norm());
        }
        EXPECT_WITHIN(worst - error.worst, .count = 16, .epsilon = kFloat) << error.precision;
        EXPECT_GE(worst, 0.3 * error.worst) << error.precision;
    }
}

/// In double each block is positive definite; rounded to float, by half of its largest entry's last digit, some are
/// not.
TEST(Precision, BlocksThatFloatCannotHoldAsPositiveDefiniteAreFound) {
    const TestModel ball(sphere_shape(2, 0.05));
    EXPECT_TRUE(has_definite_blocks(ball.tables(), ball.servo()));
    Tables tables = ball.tables();
    for (std::size_t i = 0; i < tables.stiffness.size(); ++i) {
        const Eigen::Vector3d stiff = Eigen::Vector3d(1.0, std::sin(double(i)), std::cos(double(2 * i))).normalized();
        const Eigen::Matrix3d s = stiff * stiff.transpose() + 1e-10 * Eigen::Matrix3d::Identity();
        for (Eigen::Index k = 0; k < 9; ++k) tables.stiffness[i][std::size_t(k)] = s(k / 3, k % 3);
    }
    EXPECT_FALSE(has_definite_blocks(tables, build_model(tables)));
}

// ---- compliances ----------------------------------------------------------------------------------------------------

/// The ball's tables with a compliance of this degree: any blocks, positive definite, no two alike.
Tables with_compliance(const TestModel& ball, int degree) {
    Tables tables = ball.tables();
    tables.force = degree == 2 ? ForceLaw::kConsistent : ForceLaw::kPressureMask;
    ComplianceTables& c = tables.compliance;
    c.degree = degree;
    c.edge_id = sorted_edges(tables.patch);
    int seed = 0;
    const auto fill = [&](std::vector<std::array<double, 9>>& blocks, std::size_t count) {
        for (std::size_t b = 0; b < count; ++b) {
            const double x = std::sin(++seed), y = 0.2 * std::sin(2.3 * seed), z = 0.1 * std::cos(3.1 * seed);
            blocks.push_back(
                {1e-3 * (2 + x), 1e-3 * y, 1e-3 * z, 1e-3 * y, 2e-3, 0, 1e-3 * z, 0, 1e-3 * (1.5 - 0.5 * x)});
        }
    };
    fill(c.edge, c.edge_id.size() * std::size_t(degree - 1));
    if (degree == 2) return tables;
    c.vertex_id = nodes_of(tables.patch);
    fill(c.vertex, c.vertex_id.size());
    fill(c.patch, 3 * tables.patch.size());
    return tables;
}

TEST(Precision, TheStatedErrorOfAComplianceIsAnUpperBoundOfTheServosForce) {
    const TestModel ball(sphere_shape(2, 0.05), -0.04);  // its lowest vertices are fixed
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
    for (const int degree : {2, 4}) {
        const Tables tables = with_compliance(ball, degree);
        const Stored exact(tables, Storage::kFloat32);
        const auto stated = stated_of(tables, 3.0);
        for (const PrecisionError& error : {stated[1], stated[2]}) {
            SCOPED_TRACE(testing::Message() << error.precision << ", degree " << degree);
            const Stored packed(tables, error.precision);
            EXPECT_EQ(packed.model.compliance->vertex, nullptr);
            EXPECT_EQ(flash_bytes(exact.servo) - flash_bytes(packed.servo), stated[0].bytes - error.bytes);
            double at_stated_points = 0.0, anywhere = 0.0;
            for (int trial = 0; trial < 20000; ++trial) {
                const auto patch = std::uint16_t(random() % exact.model.patch_count);
                const Eigen::Vector3f u(unit(random), unit(random), unit(random));
                const float a = 0.5F * std::abs(unit(random));
                // A corner, the middle of an edge, and any point.
                const std::array<float, 3> places[] = {{1.0F, 0.0F, 0.0F}, {0.5F, 0.5F, 0.0F}, {a, 0.3F, 0.7F - a}};
                const std::array<float, 3>& alpha = places[trial % 3];
                const Eigen::Vector3d f = force_at(exact.model, patch, alpha, u);
                double& worst = trial % 3 == 2 ? anywhere : at_stated_points;
                worst = std::max(worst, (force_at(packed.model, patch, alpha, u) - f).norm() / f.norm());
            }
            // Against the servo in float32: its own rounding, 16 operations on blocks of condition 3.
            EXPECT_WITHIN(at_stated_points - error.worst, .count = 16, .epsilon = kFloat, .condition = 3.0);
            EXPECT_GE(at_stated_points, 0.3 * error.worst);
            EXPECT_LE(anywhere, 1.5 * error.worst);
        }
    }
}

TEST(Precision, BlocksThatHalvesCannotHoldAreRefused) {
    const TestModel ball(sphere_shape(2, 0.05));
    Tables tables = with_compliance(ball, 4);
    for (double& number : tables.compliance.vertex[0]) number *= 1e-12;
    const auto stated = compare_precisions(tables, build_model(tables));
    EXPECT_NO_THROW(require_precision(stated, Storage::kFloat32));
    EXPECT_NO_THROW(require_precision(stated, Storage::kInt16));
    EXPECT_THROW(require_precision(stated, Storage::kFloat16), Error);
    // A point without compliance: 1 / 0 in every precision, and no reason to refuse one.
    for (double& number : tables.compliance.vertex[0]) number = 0.0;
    const auto singular = compare_precisions(tables, build_model(tables));
    for (const PrecisionError& error : singular) EXPECT_NO_THROW(require_precision(singular, error.precision));
}

TEST(Precision, ABudgetThatIsTooSmallSaysWhatTakesTheRoomAndWhatWouldFit) {
    const TestModel ball(sphere_shape(3, 0.05));
    const std::size_t bytes = flash_bytes(ball.servo());
    const std::pair<std::uintmax_t, const char*> budgets[] = {{0, "no error"},
                                                              {bytes, "no error"},
                                                              {bytes - 1, "precision = \"float16\" takes"},
                                                              {bytes / 4, "patches would fit"},
                                                              {1, "not one patch would fit"},
                                                              {bytes / 4, "box "}};
    for (const auto& [budget, error] : budgets)
        EXPECT_TRUE(fails_with([&] { require_flash(flash_tables(ball.servo()), ball.servo(), budget); }, error));
}

}  // namespace
}  // namespace haptable::test
