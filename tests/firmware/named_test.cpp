// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene does not name costs no byte: images of the cube, linked with more and less.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

#include "firmware/haptable_scene.h"
#include "host/base/child.hpp"
#include "host/base/shell.hpp"
#include "host/precompute/precompute.hpp"
#include "host/target/linked.hpp"
#include "tests/bodies.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPlainServo = offsetof(haptable_servo, nearest_m2);

struct Feature {
    const char* name;
    void (*ask)(Scene&);
    const char* symbol;              ///< that an image with it holds
    std::size_t more_ram_bytes = 0;  ///< than the paper's mode has, of the caller's own
};

constexpr Feature kFeatures[] = {
    {"float16", [](Scene& s) { s.tables.precision = Storage::kFloat16; }, "haptable_unpack_float16"},
    {"int16", [](Scene& s) { s.tables.precision = Storage::kInt16; }, "haptable_unpack_int16"},
    {"consistent", [](Scene& s) { s.contact.force = ForceLaw::kConsistent; }, "haptable_force_consistent"},
    {"mask",
     [](Scene& s) {
         s.contact.force = ForceLaw::kPressureMask;
         s.contact.mask_radius_m = 0.012;
     },
     "haptable_force_pressure_mask"},
    {"least energy", [](Scene& s) { s.contact.god_object = GodObject::kLeastEnergy; },
     "haptable_god_object_least_energy", sizeof(haptable_servo) - kPlainServo},
    {"friction", [](Scene& s) { s.contact.static_friction = s.contact.kinetic_friction = 0.5; },
     "haptable_god_object_friction", sizeof(haptable_freed)},  // where the god-object would be without
    {"release", [](Scene& s) { s.contact.release_n_per_ms = 0.01; }, "haptable_release_slew",
     offsetof(haptable_servo, sensitivity_per_m) - kPlainServo},
    {"passivity", [](Scene& s) { s.contact.passivity = true; }, "haptable_passivity_control",
     offsetof(haptable_servo, felt_n) - kPlainServo},
    {"relaxation",
     [](Scene& s) {
         s.relaxation.push_back({0.5, 0.1});
     },
     "haptable_relaxation", 128 + HAPTABLE_TERMS * 24},  // what the body remembers
    {"stiffening",
     [](Scene& s) {
         s.material.stiffening = Stiffening{5.0, 0.0, 0.0, {}};
     },
     "haptable_stiffening"},
    {"a body that nothing holds",
     [](Scene& s) {
         s.fixed.clear();
         s.free_body.emplace().density_kg_per_m3 = 1000.0;
     },
     "haptable_part_rigid", sizeof(haptable_body_state) + sizeof(haptable_account)},
    {"modes", [](Scene& s) { s.body_modes.emplace(4, 0.05, 1000.0, 0.0, 1); }, "haptable_part_modes",
     sizeof(haptable_modes_state) + sizeof(haptable_account)},
    {"a second finger", [](Scene& s) { s.contact.fingers = 2; }, "haptable_contacts_of_two"},
    {"display rows",
     [](Scene& s) {
         s.tables.columns = ColumnRows::kSurface;
         s.tables.display_rows = {112};  // the middle of the top
     },
     "haptable_deform", 3 * sizeof(float)},
};

const Feature& feature(const std::string& name) {
    return *std::ranges::find_if(kFeatures, [&](const Feature& one) { return one.name == name; });
}

class NamedByAScene : public testing::Test {
protected:
    void SetUp() override {
        if (!fs::exists(objects / "options")) GTEST_SKIP() << "no cross compiler: sh scripts/setup.sh cross";
    }
    LinkedServo link(const std::function<void(Scene&)>& ask, const std::string& offered = "haptable_*.o") {
        Scene scene = cube_scene(5, 0.49);
        scene.tables.columns = ColumnRows::kNone;
        ask(scene);
        const fs::path tables = folder.path() / ("cube" + std::to_string(++made));
        Progress progress(true);
        for (const TableBytes& table : precompute(scene, tables, progress).summary.size.flash) bytes += table.bytes;
        return link_servo(tables, objects, offered);
    }
    const fs::path objects = build_folder() / "cube/firmware/cortex-m7";
    const TemporaryFolder folder;
    std::size_t bytes = 0;
    int made = 0;
};

/// Also in part: of a release, of relaxation, of a body that moves.
bool names_stiffening(const LinkedServo& servo) {
    return std::ranges::any_of(servo.symbols,
                               [](const std::string& symbol) { return symbol.find("stiffen") != std::string::npos; });
}

/// A list for the shell: what the linker is offered, but files with one of these words in their names.
std::string offered_without(const std::string& words) { return "$(ls haptable_*.o | grep -vE '" + words + "')"; }

/// Bytes of code of the paper's mode with these tables, as `make firmware TARGET=cortex-m4 TARGET_OPT=-Os` counts them.
std::size_t smallest_code(const fs::path& tables, const fs::path& work) {
    const std::string command = "build=" + build_folder().string() + " tables=" + tables.string() +
                                " work=" + work.string() + R"(; mkdir -p $work/port
        options=$(cat $build/cube/firmware/cortex-m4/options)
        compile="$(echo "${options%% -MMD*}" | sed 's/ -O2 / -Os /') -I$tables"
        for file in firmware/haptable_{check,contact,crc,entry,force,force_interpolated,limit,patch,plausible}.c \
            firmware/haptable_{scene,scene_one,servo,side}.c \
            firmware/port/{haptable_cortex_m,haptable_semihosting,haptable_memory,haptable_ticks}.c; do
            object=${file#firmware/}; object=$work/${object%.c}.o
            [ -e $object ] || $compile -c $file -o $object || exit 1 # it reads no scene's model.h
        done
        $compile -c firmware/port/replay.c -o $work/port/replay.o && $compile -c $tables/model.c -o $work/model.o &&
        arm-none-eabi-gcc ${options##* -MP} -Wl,-Map=$work/replay.map -o $work/replay.elf $work/port/*.o $work/*.o -lgcc &&
        CROSS=arm-none-eabi- sh scripts/size.sh $work replay | awk '/code of the servo/ { print $5 }')";
    const auto ran = run_shell("bash -c " + shell_quoted(command));
    return ran.status == 0 && !ran.out.empty() ? std::stoul(ran.out) : 0;
}

TEST_F(NamedByAScene, ThePapersModeIsSmall) {
    Progress progress(true);
    Scene scene = cube_scene(5, 0.49);
    scene.tables.columns = ColumnRows::kNone;
    precompute(scene, folder.path() / "without", progress);
    const std::size_t without = smallest_code(folder.path() / "without", folder.path() / "work");
    const std::size_t with = smallest_code(build_folder() / "cube", folder.path() / "work");
    EXPECT_GT(without, 0U) << "it compiles";
    EXPECT_LE(without, 9000U);
    EXPECT_GT(with, without + 1000U) << "limits and check";
    EXPECT_LE(with, 11000U);
}

// The image of the paper's mode is the same when all else is not even there to be linked.
TEST_F(NamedByAScene, WhatIsNotNamedIsNotLinked) {
    const auto nothing = [](Scene&) {};
    const LinkedServo plain = link(nothing);
    const LinkedServo alone = link(nothing,
                                   "haptable_contact.o haptable_entry.o haptable_force.o haptable_force_interpolated.o "
                                   "haptable_patch.o haptable_scene.o haptable_scene_one.o haptable_servo.o "
                                   "haptable_side.o");
    EXPECT_EQ(plain.flash, alone.flash);
    EXPECT_EQ(plain.ram, alone.ram);
    EXPECT_EQ(plain.symbols, alone.symbols);
    EXPECT_TRUE(plain.image == alone.image) << "byte for byte";
    const std::size_t ticks = sizeof(haptable_input) + sizeof(haptable_output) + 12;
    EXPECT_EQ(plain.ram, kPlainServo + ticks) << "the caller's own";
    EXPECT_GT(plain.flash, bytes / 2 + 4000) << "it is the servo with its tables";
    for (const char* name :
         {"compliance_solve", "haptable_energy_consistent", "haptable_god_object_grab", "haptable_plausible_motion",
          "haptable_limit_rate", "haptable_limit_mean", "haptable_resume_ramp", "haptable_check_crc"})
        EXPECT_FALSE(plain.symbols.contains(name)) << name;
    const LinkedServo limited = link([](Scene& s) {
        s.device.limits.max_force_rate_n_per_s = 850.0;
        s.device.limits.check = true;
    });
    EXPECT_TRUE(limited.symbols.contains("haptable_limit_rate") && limited.symbols.contains("haptable_check_crc"));
    EXPECT_FALSE(limited.symbols.contains("haptable_limit_mean") ||
                 limited.symbols.contains("haptable_plausible_motion"));
    for (const Feature& asked : kFeatures) {
        SCOPED_TRACE(asked.name);
        EXPECT_FALSE(plain.symbols.contains(asked.symbol));
        const LinkedServo with = link(asked.ask);
        const std::string name = asked.name;
        EXPECT_EQ(names_stiffening(with), name == "stiffening");
        for (const char* other : {"haptable_step_tool", "haptable_step_hands"})
            EXPECT_FALSE(with.symbols.contains(other)) << other;
        for (const Feature& other : kFeatures)
            EXPECT_EQ(with.symbols.contains(other.symbol), other.name == name) << "brings " << other.name;
        if (name == "a second finger")
            EXPECT_TRUE(2 * (sizeof(haptable_servo) + ticks) < with.ram &&
                        with.ram <= sizeof(haptable_pair) + 2 * ticks)
                << with.ram << ": two servos and what couples them, whose pointers take half of the host's";
        else
            EXPECT_EQ(with.ram, plain.ram + asked.more_ram_bytes);
    }
}

TEST_F(NamedByAScene, AToolIsLinkedWithoutASecondFinger) {
    const auto held = [](GodObject god_object) {
        return [god_object](Scene& s) {
            s.contact.force = ForceLaw::kConsistent;
            s.contact.god_object = god_object;
            s.tool.emplace().point_m = {{-0.003, 0.0, 0.0}, {0.003, 0.0, 0.0}};
        };
    };
    const LinkedServo nearest = link(held(GodObject::kNearest)), least = link(held(GodObject::kLeastEnergy));
    for (const LinkedServo* servo : {&nearest, &least}) {
        EXPECT_TRUE(servo->symbols.contains("haptable_step_tool"));
        EXPECT_FALSE(servo->symbols.contains("haptable_contacts_of_two"));
    }
    EXPECT_FALSE(nearest.symbols.contains("haptable_points_settle"));
    EXPECT_TRUE(least.symbols.contains("haptable_points_settle"));
}

// Each of the eight combinations holds what its parts are made of, and is byte for byte the image that is linked where
// the files of the other parts are not even there: they cost no byte, and no instruction.
TEST_F(NamedByAScene, EveryCombinationPaysForItsPartsAlone) {
    std::set<std::string> all;
    for (const bool two : {false, true})
        for (const bool is_free : {false, true})
            for (const bool rings : {false, true}) {
                SCOPED_TRACE(std::string(two ? "two fingers" : "one finger") + (is_free ? ", free" : ", held") +
                             (rings ? ", with modes" : ""));
                const auto ask = [&](Scene& s) {
                    if (two) feature("a second finger").ask(s);
                    if (is_free) feature("a body that nothing holds").ask(s);
                    if (rings) feature("modes").ask(s);
                    if (is_free && rings) s.body_modes->density_kg_per_m3 = 0.0;
                };
                std::string without = two ? "none" : "pair";
                if (!is_free) without += "|body";
                if (!rings) without += "|modes|rows";
                if (!is_free && !rings) without += "|moving";
                const LinkedServo whole = link(ask), alone = link(ask, offered_without(without));
                EXPECT_EQ(whole.symbols, alone.symbols);
                EXPECT_TRUE(whole.image == alone.image) << "byte for byte";
                EXPECT_EQ(whole.symbols.contains("haptable_contacts_of_two"), two);
                EXPECT_EQ(whole.symbols.contains("haptable_contact_of_one"), !two && (is_free || rings));
                EXPECT_EQ(whole.symbols.contains("haptable_part_rigid"), is_free);
                EXPECT_EQ(whole.symbols.contains("haptable_part_modes"), rings);
                EXPECT_EQ(whole.symbols.contains("haptable_moving"), is_free || rings);
                EXPECT_EQ(whole.symbols.contains("haptable_rows_of_two"), two && rings);
                all.insert(whole.image);
            }
    EXPECT_EQ(all.size(), 8U);
}

// One patch touched: the code of a region with a border, and the tables of three nodes.
TEST_F(NamedByAScene, ATouchRegionPaysForItsPatchesAlone) {
    const LinkedServo plain = link([](Scene&) {});
    bytes = 0;
    const LinkedServo top = link([](Scene& s) {
        s.touch.push_back({std::array{-1.0, -1.0, 0.03 - 1e-9, 1.0, 1.0, 1.0}, "", 1});
    });
    const std::size_t whole = bytes;
    bytes = 0;
    const LinkedServo one = link([](Scene& s) {
        for (const auto& [x, y] : {std::pair{0.0075, 0.0075}, {0.015, 0.0075}, {0.0075, 0.015}})
            s.touch.push_back({std::array{x - 1e-9, y - 1e-9, 0.03 - 1e-9, x + 1e-9, y + 1e-9, 0.03 + 1e-9}, "", 1});
    });
    // A position and a block a node; a patch's corners and neighbours; one box.
    EXPECT_EQ(bytes, 3U * (12 + 24) + (6 + 6) + 16);
    std::set<std::string> with_border = plain.symbols;
    with_border.insert("haptable_hinges_of_table");
    EXPECT_EQ(top.symbols, with_border) << "a closed body does not link it";
    EXPECT_EQ(one.symbols, with_border);
    EXPECT_NEAR(double(top.flash - one.flash), double(whole - bytes), 16.0) << "alignment";
}

}  // namespace
}  // namespace haptable::test
