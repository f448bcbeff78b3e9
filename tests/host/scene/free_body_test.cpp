// SPDX-License-Identifier: GPL-2.0-or-later
// [body] free = true: what it reads, and errors that name line and key.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "host/scene/scene.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

const std::string kHead = R"(name = "a"
[mesh]
generate = "cube"
[material]
young = 1000
poisson = 0.3
)";

class FreeBodyScene : public testing::Test {
protected:
    Scene read(const std::string& rest) {
        write_file(path_, kHead + rest);
        return read_scene(path_);
    }
    /// rest begins at line 7.
    void expect_error(const std::string& rest, int line, const std::string& part, const std::string& of = "body.") {
        const std::string what = test::error_of([&] { read(rest); });
        EXPECT_TRUE(what.starts_with(path_.string() + ":" + std::to_string(line) + ": " + of + part)) << what;
    }

    const test::TemporaryFolder folder_;
    const std::filesystem::path path_ = folder_.path() / "scene.toml";
};

TEST_F(FreeBodyScene, ReadsWhatHoldsIt) {
    const Scene scene = read(
        "[body]\nfree = true\nmass = 0.5\nsuspension = [1, 2, 3, 4, 5, 6]\n"
        "suspension_damping = [0, 0, 0, 0, 0, 7]\nfloor = -0.01\nfloor_normal = [0, 0, 2]\n");
    ASSERT_TRUE(scene.free_body);
    EXPECT_EQ(scene.free_body->mass_kg, 0.5);
    EXPECT_EQ(scene.free_body->stiffness, (std::array<double, 6>{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(scene.free_body->damping[5], 7.0);
    ASSERT_TRUE(scene.free_body->floor);
    EXPECT_EQ(scene.free_body->floor->height_m, -0.01);
    EXPECT_EQ(scene.free_body->floor->normal[2], 1.0);
    EXPECT_EQ(scene.free_body->floor->friction, 0.5);
    EXPECT_FALSE(read("[body]\nfree = false\n").free_body);
    EXPECT_FALSE(read("").free_body);
}

TEST_F(FreeBodyScene, AFloorIsBelowByGravity) {
    const Scene scene = read("[gravity]\ndensity = 900\ndirection = [1, 0, 0]\n[body]\nfree = true\nfloor = 0\n");
    EXPECT_EQ(scene.free_body->floor->normal, (std::array<double, 3>{-1.0, 0.0, 0.0}));
    EXPECT_EQ(scene.density_of(-1), 900.0);
    EXPECT_EQ(read("[body]\nfree = true\ndensity = 700\n").density_of(-1), 700.0);
}

TEST_F(FreeBodyScene, ErrorsNameLineAndKey) {
    expect_error("[body]\nfree = true\n", 7, "density: is missing");
    expect_error("[body]\nfree = true\ndensity = -1\n", 9, "density: is -1");
    expect_error("[body]\nfree = true\nmass = 1\nweight = 1\n", 10, "weight: unknown key");
    expect_error("[[fixed]]\nbox = [0,0,0,1,1,1]\n[body]\nfree = true\nmass = 1\n", 10, "free: is true, and [[fixed]]");
    expect_error("[[bed]]\nbox = [0,0,0,1,1,1]\nnormal = 1\n[body]\nfree = true\nmass = 1\n", 11,
                 "free: is true, and [[bed]]");
    expect_error("[gravity]\ndensity = 9\n[body]\nfree = true\ndensity = 1\n", 11, "density: is in [gravity] already");
    expect_error("[gravity]\ndensity = 9\nprestress = true\n[body]\nfree = true\n", 11, "free: is true, and prestress");
    expect_error("[body]\nfree = true\nmass = 1\nsuspension = [1, 2]\n", 10, "suspension: must be six");
    expect_error("[body]\nfree = true\nmass = 1\nsuspension = [1, 2, 3, -4, 5, 6]\n", 10, "suspension: has -4");
    expect_error("[body]\nfree = true\nmass = 1\nsuspension_damping = [1, 2, 3, 4, 5, 6]\n", 10,
                 "suspension_damping: needs suspension");
    expect_error("[body]\nfree = true\nmass = 1\nfloor_friction = 1\n", 10, "floor_friction: needs floor");
    expect_error("[body]\nfree = true\nmass = 1\nfloor = 0\nfloor_normal = [0, 0, 0]\n", 11, "floor_normal:");
    for (const char* key : {"floor = 0", "floor_normal = [0, 0, 1]", "floor_friction = 1"})
        expect_error(fmt::format("[body]\n{}\n", key), 8,
                     std::string(key).substr(0, std::string(key).find(' ')) + ": is of a body that is not held");
    expect_error("[body]\nfree = true\nmass = 0.99e-6\n", 9, "mass: is 9.9e-07 kg, and a servo moves 1e-06 to 1e+06");
    expect_error("[body]\nfree = true\nmass = 1.01e6\n", 9, "mass: is 1.01e+06 kg");
    expect_error("[body]\nmodes = 4\nmass = 1e-15\n", 9, "mass: is 1e-15 kg");
    EXPECT_EQ(read("[body]\nfree = true\nmass = 1e-6\n").free_body->mass_kg, 1e-6);
    EXPECT_EQ(read("[body]\nfree = true\nmass = 1e6\n").free_body->mass_kg, 1e6);
    expect_error("[body]\nmass = 1\n", 8, "mass: is of a body that moves; add free = true or modes");
}

// Only its contacts push it: no force goes on after one, unless the scene says so, and then that is refused.
TEST_F(FreeBodyScene, ContactsAloneActOnIt) {
    const std::string free = "[body]\nfree = true\nmass = 1\n", least = "[contact]\ngod_object = \"least-energy\"\n";
    EXPECT_GT(read(least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(free + least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(free + least + "release_slew = 0\npassivity = false\n").contact.release_n_per_ms, 0.0);
    expect_error(free + least + "release_slew = 0.01\n", 12, "release_slew: keeps a force up", "contact.");
    expect_error(free + least + "passivity = true\n", 12, "passivity: is what the motion", "contact.");
}

TEST_F(FreeBodyScene, GoesByTheLeastEnergyUnlessTheSceneSaysOtherwise) {
    const std::string free = "[body]\nfree = true\nmass = 1\n", nearest = "[contact]\ngod_object = \"nearest\"\n";
    EXPECT_EQ(read("").contact.god_object, GodObject::kNearest);
    EXPECT_EQ(read(free).contact.god_object, GodObject::kLeastEnergy);
    EXPECT_EQ(read(free + nearest).contact.god_object, GodObject::kNearest);
}

TEST_F(FreeBodyScene, ABodyThatIsHeldMayRing) {
    const Scene scene = read("[body]\nmodes = 6\ndensity = 900\nmass = 0.1\n");
    ASSERT_TRUE(scene.body_modes);
    EXPECT_FALSE(scene.free_body);
    EXPECT_EQ(scene.body_modes->modes, 6);
    EXPECT_EQ(scene.body_modes->line, 8) << "for codegen's errors";
    EXPECT_EQ(scene.body_modes->damping_ratio, 0.05);
    EXPECT_EQ(scene.density_of(-1), 900.0);
    EXPECT_EQ(scene.mass_kg(), 0.1);
    EXPECT_FALSE(read("[body]\nmodes = 0\n").body_modes);
}

TEST_F(FreeBodyScene, ABodyThatNothingHoldsMayRing) {
    const Scene scene = read("[body]\nfree = true\nmodes = 8\nmode_damping = 0.1\ndensity = 700\nmass = 0.2\n");
    ASSERT_TRUE(scene.body_modes && scene.free_body);
    EXPECT_EQ(scene.body_modes->damping_ratio, 0.1);
    EXPECT_EQ(scene.density_of(-1), 700.0);
    EXPECT_EQ(scene.mass_kg(), 0.2);
}

TEST_F(FreeBodyScene, ErrorsOfModesNameLineAndKey) {
    expect_error("[body]\nmodes = 17\nmass = 1\n", 8, "modes: is 17, and a servo has 0 to 16");
    expect_error("[body]\nmodes = 8\n", 7, "density: is missing: a body that rings");
    expect_error("[body]\nmodes = 8\nmass = 1\nmode_damping = 1\n", 10, "mode_damping: is 1, the ratio");
    expect_error("[body]\nmodes = 8\nmass = 1\nmode_damping = 0.00001\n", 10, "mode_damping: is 1e-05, the ratio");
    expect_error("[body]\nmodes = -1\nmass = 1\n", 8, "modes: is -1, and a servo has 0 to 16");
    expect_error("[body]\nfree = true\nmass = 1\nmode_damping = 0.1\n", 10, "mode_damping: needs modes");
    expect_error("[gravity]\ndensity = 9\n[body]\nmodes = 2\ndensity = 1\n", 11, "density: is in [gravity] already");
    expect_error("[gravity]\ndensity = 9\nprestress = true\n[body]\nmodes = 2\n", 11, "modes: are those of the body");
    EXPECT_EQ(read("[body]\nfree = true\nmodes = 2\nmass = 1\n[contact]\nfingers = 2\n").contact.fingers, 2);
    expect_error("[body]\nmodes = 2\nmass = 1\n[[relaxation]]\nshare = 0.5\ntime = 1\n", 8,
                 "modes: are of an elastic body");
    expect_error("[body]\nmodes = 2\nmass = 1\n[contact]\npassivity = true\n", 8, "modes: count what contacts give");
}

}  // namespace
}  // namespace haptable
