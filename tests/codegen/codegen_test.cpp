// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/codegen.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <random>

#include "codegen/template.hpp"
#include "firmware/haptable.h"
#include "firmware/haptable_scene.h"
#include "host/base/file.hpp"
#include "host/scene/keys.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

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
    other_version.header = replaced(text.header, guard, "HAPTABLE_TABLE_VERSION != 0");
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

TEST(Codegen, RefusesWhatAServoCannotHold) {
    const TestModel model(box_shape(2, Vector3d(0.03, 0.03, 0.03)));
    for (const auto& [change, said] : std::initializer_list<std::pair<void (*)(Tables&), const char*>>{
             {[](Tables& tables) { tables.stiffness[3][4] = std::nan(""); }, "a stiffness = nan does not fit a float"},
             {[](Tables& tables) { tables.position[2][0] = 1e300; }, "a position = 1e+300 does not fit a float"},
             {[](Tables& tables) { tables.patch.resize(HAPTABLE_NONE, tables.patch[0]); }, "[[touch]]"}}) {
        Tables tables = model.tables();
        change(tables);
        EXPECT_TRUE(fails_with([&] { build_model(tables); }, said));
    }
}

TEST(Codegen, RefusesAVertexOfMorePatchesThanATickLooksAt) {
    EXPECT_NO_THROW(TestModel(spindle_shape(HAPTABLE_FAN_PATCHES, 0.02, 0.03)));
    EXPECT_TRUE(fails_with([] { const TestModel model(spindle_shape(HAPTABLE_FAN_PATCHES + 1, 0.02, 0.03)); },
                           "33 touchable patches meet at node 33"));
}

// ---- templates ------------------------------------------------------------------------------------------------------

const TemplateValues kValues{
    {"name", "cube"}, {"none", ""}, {"rows", "    1,\n    2,\n"}, {"row", "    3,"}, {"mail", "a@b"}};

TEST(Template, PlacesAreFilled) {
    EXPECT_EQ(filled("int @name@_@name@;\n", kValues), "int cube_cube;\n");
    EXPECT_EQ(filled("@name@", kValues), "cube");
    EXPECT_EQ(filled("by me@example.org, and @name@ by @mail@", kValues), "by me@example.org, and cube by a@b");
}

TEST(Template, ALineThatIsAPlaceIsItsValuesLines) {
    EXPECT_EQ(filled("a[] = {\n@rows@\n@row@\n@none@\n};\n", kValues), "a[] = {\n    1,\n    2,\n    3,\n};\n");
}

TEST(Template, OnlyTheBranchOfAValueStays) {
    EXPECT_EQ(filled("a\n@if name\nb\n@else\nc\n@end\nd\n", kValues), "a\nb\nd\n");
    EXPECT_EQ(filled("a\n@if none\nb\n@else\nc\n@end\nd\n", kValues), "a\nc\nd\n");
    EXPECT_EQ(filled("@if name\n@if none\nb\n@else\nc\n@end\nd\n@end\n", kValues), "c\nd\n");
    EXPECT_EQ(filled("@if none\n@if unknown\n@unknown@\n@else\nc\n@end\n@end\nd\n", kValues), "d\n");
}

TEST(Template, ANameWithoutAValueIsAnError) {
    EXPECT_EQ(error_of([] { filled("@nobody@", kValues); }), "a template asks for @nobody@, which has no value");
    EXPECT_NE(error_of([] { filled("@if nobody\n@end\n", kValues); }), "no error");
}

// ---- what the firmware names ----------------------------------------------------------------------------------------

// HAPTABLE_MOVERS is the one list. That of laws: test_keys.py.
TEST(Laws, ThePageOfWhatMovesHasEachMover) {
    const std::string page = read_file("docs/MOVING.md");
    const std::string table = page.substr(page.find("\n|"), page.find("\n\n", page.find("\n|")) - page.find("\n|"));
    for (const char* title : {
#define HAPTABLE_TITLE(PART, KEY, WORD, TITLE, ...) TITLE,
             HAPTABLE_MOVERS(HAPTABLE_TITLE)})
        EXPECT_TRUE(says(table, title)) << "docs/MOVING.md, its first table: " << title;
}

/// True for a key of a scene that changes the tables.
bool changes_tables(const std::string& key) {
    for (const Key& one : scene_keys())
        if (key == std::string(one.section) + "." + one.name) return one.changes == Changes::kTables;
    return false;
}

TEST(Laws, KeysThatTheFirmwareNamesAreAScenes) {
    for (const char* key : {
#define HAPTABLE_MOVER_KEY(PART, KEY, ...) KEY,
#define HAPTABLE_VALUE_KEY(FIELD, KEY) KEY,
#define HAPTABLE_STAGE_KEY(FIELD, FUNCTION, KEY) KEY,
             HAPTABLE_MOVERS(HAPTABLE_MOVER_KEY) HAPTABLE_MODEL_KEYS(HAPTABLE_VALUE_KEY, HAPTABLE_STAGE_KEY)})
        EXPECT_TRUE(changes_tables(key)) << key;
}

}  // namespace
}  // namespace haptable::test
