// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/codegen.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cstdlib>
#include <limits>
#include <random>

#include "firmware/haptable.h"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

TEST(Codegen, NeighboursLieAcrossTheirEdgeAndBack) {
    const TestModel model(torus_shape(20, 10, 0.05, 0.02));
    const ServoModel& servo = model.servo();
    for (std::size_t p = 0; p < servo.patch.size(); ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::uint16_t q = servo.neighbour[p][c];
            ASSERT_NE(q, HAPTABLE_NONE) << "the torus is closed";
            EXPECT_EQ(std::count(servo.neighbour[q].begin(), servo.neighbour[q].end(), p), 1);
            const auto corner = servo.patch[p][c];
            EXPECT_EQ(std::count(servo.patch[q].begin(), servo.patch[q].end(), corner), 0);
        }
}

// Two bars that touch along one edge: four patches meet there, and each bar's two are neighbours.
TEST(Codegen, WherePatchesOfTwoBodiesMeetAtAnEdgeEachKeepsToItsOwn) {
    const Shape one = box_shape(1, Vector3d(1, 1, 1));
    Shape both = one;
    std::vector<std::int32_t> node_of;
    for (const Vector3d& point : one.point) {
        const Vector3d x = point + Vector3d(1, 1, 0);
        const auto same = std::find(one.point.begin(), one.point.end(), x);
        node_of.push_back(std::int32_t(same == one.point.end() ? both.point.size() : same - one.point.begin()));
        if (same == one.point.end()) both.point.push_back(x);
    }
    for (auto patch : one.patch) {
        for (std::int32_t& node : patch) node = node_of[std::size_t(node)];
        both.patch.push_back(patch);
    }
    ASSERT_EQ(both.point.size(), 14U);
    const TestModel model(both);
    const ServoModel& servo = model.servo();
    const auto is_first = [&](std::size_t p) { return servo.leaf_order[p] < one.patch.size(); };
    for (std::size_t p = 0; p < servo.patch.size(); ++p)
        for (std::uint16_t q : servo.neighbour[p]) EXPECT_EQ(is_first(p), is_first(q)) << p << " and " << q;
}

TEST(Codegen, EveryPatchLiesInItsLeafAndEveryBoxInItsParent) {
    const TestModel model(sphere_shape(3, 0.05));
    const ServoModel& servo = model.servo();
    std::size_t covered = 0;
    for (std::size_t b = 0; b < servo.box.size(); ++b) {
        const haptable_box& box = servo.box[b];
        ASSERT_GT(box.skip, b);
        ASSERT_LE(box.skip, servo.box.size());
        for (std::size_t child = b + 1; child < box.skip; ++child)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                EXPECT_LE(box.low[axis], servo.box[child].low[axis]);
                EXPECT_GE(box.high[axis], servo.box[child].high[axis]);
            }
        if (box.patch == HAPTABLE_NONE) continue;
        EXPECT_EQ(box.patch, covered) << "leaves hold the patches in a row";
        for (int i = 0; i < HAPTABLE_LEAF && covered < servo.patch.size(); ++i, ++covered)
            for (std::uint16_t v : servo.patch[covered])
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const float steps = (servo.vertex_m[v][axis] - servo.grid_origin_m[axis]) * servo.grid_per_m;
                    EXPECT_LE(float(box.low[axis]) + 1, steps);
                    EXPECT_GE(float(box.high[axis]) - 1, steps);
                }
    }
    EXPECT_EQ(covered, servo.patch.size());
}

TEST(Codegen, FreeVerticesComeFirstAndBlocksArePackedInOrder) {
    const TestModel model(box_shape(3, Vector3d(0.03, 0.03, 0.03)), 0.001);
    const ServoModel& servo = model.servo();
    ASSERT_EQ(servo.free_count, 56U - 16U);
    for (std::size_t v = 0; v < servo.node.size(); ++v) EXPECT_EQ(servo.vertex_m[v][2] < 0.001F, v >= servo.free_count);
    const auto& s = model.tables().stiffness[5];
    const std::array<double, 6> packed{s[0], s[4], s[8], s[1], s[5], s[6]};
    const double noise = 0x1p-26 * *std::max_element(packed.begin(), packed.end());
    for (std::size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(double(servo.stiffness_n_per_m[5][i]), packed[i], noise + 0x1p-24 * std::abs(packed[i]));
}

// Another BLAS adds in another order: 1e-16 of a block, where symmetry gives 0 too.
TEST(Codegen, TheLastBitsOfABlockChangeNoText) {
    const TestModel model(box_shape(4, Vector3d(0.03, 0.03, 0.03)));
    Tables tables = model.tables();
    for (auto& block : tables.stiffness)
        for (const std::size_t i : {1, 3, 5, 7}) block[i] = 0.0;
    const ModelText exact = model_text(tables, build_model(tables));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> noise(-4e-15, 4e-15);
    for (auto& block : tables.stiffness) {
        const double size = *std::max_element(block.begin(), block.end());
        for (double& entry : block) entry += noise(random) * size;
    }
    const ServoModel servo = build_model(tables);
    EXPECT_EQ(model_text(tables, servo).source, exact.source);
    EXPECT_EQ(model_text(tables, servo).header, exact.header);
    for (const auto& block : servo.stiffness_n_per_m)
        for (const std::size_t i : {3, 4}) EXPECT_EQ(std::bit_cast<std::uint32_t>(block[i]), 0U) << "+0";
    // Of what is no noise an eighth of a float's last bit is kept.
    tables.stiffness[5][1] = tables.stiffness[5][3] = 0x1p-25 * tables.stiffness[5][0];
    EXPECT_GT(build_model(tables).stiffness_n_per_m[5][3], 0.0F);
}

/// Compiles a model's text with the firmware's warnings; returns the compiler's exit status.
int compile(const ModelText& text) {
    const TemporaryFolder folder;
    write_file(folder.path() / "model.h", text.header);
    write_file(folder.path() / "model.c", text.source);
    const std::string model = (folder.path() / "model").string();
    return run("gcc -std=c99 -ffreestanding -pedantic -Wall -Wextra -Wconversion -Wdouble-promotion -Werror -Ifirmware "
               "-c " +
               model + ".c -o " + model + ".o")
        .status;
}

TEST(Codegen, TheTextCompilesWithoutAWarningAndGuardsItsVersionAndSizes) {
    const TestModel model(box_shape(2, Vector3d(0.03, 0.03, 0.03)), 0.001);
    ModelText text = model_text(model.tables(), model.servo());
    EXPECT_EQ(compile(text), 0);

    ModelText other_version = text;
    const std::string guard = "HAPTABLE_TABLE_VERSION != " + std::to_string(HAPTABLE_TABLE_VERSION);
    other_version.header.replace(other_version.header.find(guard), guard.size(), "HAPTABLE_TABLE_VERSION != 0");
    EXPECT_NE(compile(other_version), 0) << "tables of another version must not compile";

    ModelText short_table = text;
    const auto last = short_table.header.find("_TABLE_BYTES ");
    short_table.header.insert(short_table.header.find('\n', last), " + 4");
    EXPECT_NE(compile(short_table), 0) << "the sizes are asserted";
}

TEST(Codegen, FloatsReadBackToTheSameBits) {
    Shape shape = box_shape(1, Vector3d(1, 1, 1));
    shape.point[0] = Vector3d(-0.1, 1e-30, -0.0);
    const TestModel model(shape);
    const std::string source = model_text(model.tables(), model.servo()).source;
    for (const auto& x : model.servo().vertex_m)
        for (float value : x) {
            char digits[64];
            std::snprintf(digits, sizeof digits, "%.9g", double(value));
            EXPECT_EQ(std::strtof(digits, nullptr), value);
            EXPECT_TRUE(says(source, digits)) << digits;
        }
}

TEST(Codegen, StopsAtAValueThatIsNoNumber) {
    const TestModel model(box_shape(2, Vector3d(0.03, 0.03, 0.03)));
    Tables tables = model.tables();
    tables.stiffness[3][4] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(build_model(tables), Error);
    tables = model.tables();
    tables.position[2][0] = 1e300;
    EXPECT_THROW(build_model(tables), Error);
}

TEST(Codegen, RefusesAVertexOfMorePatchesThanATickLooksAt) {
    EXPECT_NO_THROW(TestModel(spindle_shape(HAPTABLE_FAN_PATCHES, 0.02, 0.03)));
    EXPECT_TRUE(fails_with([] { const TestModel model(spindle_shape(HAPTABLE_FAN_PATCHES + 1, 0.02, 0.03)); },
                           "33 touchable patches meet at node 33"));
}

TEST(Codegen, RefusesAnObjectTooLargeForItsIndices) {
    const TestModel model(box_shape(2, Vector3d(0.03, 0.03, 0.03)));
    Tables tables = model.tables();
    while (tables.patch.size() < HAPTABLE_NONE)
        tables.patch.insert(tables.patch.end(), model.tables().patch.begin(), model.tables().patch.end());
    EXPECT_TRUE(fails_with([&] { build_model(tables); }, "[[touch]]"));
}

}  // namespace
}  // namespace haptable::test
