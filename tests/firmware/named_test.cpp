// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene does not name costs no byte: images of the cube, linked with more and less.
#include <gtest/gtest.h>

#include <functional>

#include "firmware/haptable_body.h"
#include "firmware/haptable_modes.h"
#include "host/precompute/precompute.hpp"
#include "host/target/linked.hpp"
#include "tests/bodies.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

struct Feature {
    const char* name;
    std::function<void(Scene&)> ask;
    const char* symbol;  ///< that an image with it holds
};

const Feature kFeatures[] = {
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
     "haptable_god_object_least_energy"},
    {"friction", [](Scene& s) { s.contact.static_friction = s.contact.kinetic_friction = 0.5; },
     "haptable_god_object_friction"},
    {"release", [](Scene& s) { s.contact.release_n_per_ms = 0.01; }, "haptable_release_slew"},
    {"passivity", [](Scene& s) { s.contact.passivity = true; }, "haptable_passivity_control"},
    {"relaxation",
     [](Scene& s) {
         s.relaxation = {{0.5, 0.1}};
     },
     "haptable_relaxation"},
    {"a body that nothing holds",
     [](Scene& s) {
         s.fixed.clear();
         s.free_body = FreeBody{};
         s.free_body->density_kg_per_m3 = 1000.0;
     },
     "haptable_body_step"},
    {"modes",
     [](Scene& s) {
         s.vibration = Vibration{4, 0.05, 1000.0, 0.0, 1};
     },
     "haptable_modes_step"},
    {"display rows",
     [](Scene& s) {
         s.tables.columns = ColumnRows::kSurface;
         s.tables.display_rows = {112};  // the middle of the top
     },
     "haptable_deform"},
};

class NamedByAScene : public testing::Test {
protected:
    NamedByAScene() : objects(build_folder() / "cube/firmware/cortex-m7") {}
    LinkedServo link(const std::function<void(Scene&)>& ask, const std::string& offered = "haptable_*.o") {
        Scene scene = cube_scene(5, 0.49);
        scene.tables.columns = ColumnRows::kNone;
        ask(scene);
        const fs::path tables = folder.path() / ("cube" + std::to_string(++made));
        Progress progress(true);
        for (const TableBytes& table : precompute(scene, tables, progress).summary.size.flash) bytes += table.bytes;
        return link_servo(tables, objects, offered);
    }
    const fs::path objects;
    const TemporaryFolder folder;
    std::size_t bytes = 0;
    int made = 0;
};

// The image of the paper's mode is the same when all else is not even there to be linked.
TEST_F(NamedByAScene, WhatIsNotNamedIsNotLinked) {
    if (const std::string missing = missing_for_link(objects); !missing.empty()) GTEST_SKIP() << missing;
    const auto nothing = [](Scene&) {};
    const LinkedServo plain = link(nothing);
    const LinkedServo alone =
        link(nothing,
             "haptable_contact.o haptable_entry.o haptable_force.o haptable_force_interpolated.o haptable_hinge.o "
             "haptable_patch.o haptable_servo.o haptable_surface.o");
    EXPECT_EQ(plain.flash, alone.flash);
    EXPECT_EQ(plain.ram, alone.ram);
    EXPECT_EQ(plain.symbols, alone.symbols);
    EXPECT_TRUE(plain.image == alone.image) << "byte for byte";
    EXPECT_EQ(plain.ram, sizeof(haptable_servo) + sizeof(haptable_output) + 12) << "the caller's own";
    EXPECT_GT(plain.flash, bytes / 2 + 4000) << "it is the servo with its tables";
    for (const Feature& feature : kFeatures) {
        SCOPED_TRACE(feature.name);
        EXPECT_FALSE(plain.symbols.contains(feature.symbol));
        const LinkedServo with = link(feature.ask);
        EXPECT_TRUE(with.symbols.contains(feature.symbol)) << "the test knows its name";
        EXPECT_FALSE(with.symbols.contains("haptable_modes_pair_step")) << "brings a second finger";
        for (const Feature& other : kFeatures) {
            if (std::string(other.name) == feature.name) continue;
            EXPECT_FALSE(with.symbols.contains(other.symbol)) << "brings " << other.name;
        }
        if (std::string(feature.name) == "display rows")
            EXPECT_EQ(with.ram, plain.ram + 12) << "three floats a row";
        else if (std::string(feature.name) == "relaxation")
            EXPECT_EQ(with.ram, plain.ram + 132 + HAPTABLE_TERMS * 24) << "what the body remembers";
        else if (std::string(feature.name) == "a body that nothing holds")
            EXPECT_EQ(with.ram, plain.ram + sizeof(haptable_body_state)) << "where it is and how it moves";
        else if (std::string(feature.name) == "friction")
            EXPECT_EQ(with.ram, plain.ram + 56) << "where the god-object would be without";
        else if (std::string(feature.name) == "modes")
            EXPECT_EQ(with.ram, plain.ram + sizeof(haptable_modes_state)) << "how far they have swung";
        else
            EXPECT_EQ(with.ram, plain.ram) << "no other mode has a state of its own";
    }
}

// One patch touched: the same code, and the tables of three nodes.
TEST_F(NamedByAScene, ATouchRegionPaysForItsPatchesAlone) {
    if (const std::string missing = missing_for_link(objects); !missing.empty()) GTEST_SKIP() << missing;
    const LinkedServo plain = link([](Scene&) {});
    const std::size_t whole = bytes;
    bytes = 0;
    const LinkedServo one = link([](Scene& s) {
        for (const auto& [x, y] : {std::pair{0.0075, 0.0075}, {0.015, 0.0075}, {0.0075, 0.015}})
            s.touch.push_back({std::array{x - 1e-9, y - 1e-9, 0.03 - 1e-9, x + 1e-9, y + 1e-9, 0.03 + 1e-9}, "", 1});
    });
    // A position and a block a node; a patch's corners and neighbours; one box.
    EXPECT_EQ(bytes, 3U * (12 + 24) + (6 + 6) + 16);
    EXPECT_EQ(plain.symbols, one.symbols);
    EXPECT_NEAR(double(plain.flash - one.flash), double(whole - bytes), 16.0) << "alignment";
}

}  // namespace
}  // namespace haptable::test
