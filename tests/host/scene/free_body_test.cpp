// SPDX-License-Identifier: GPL-2.0-or-later
// [body] free = true: what it reads.
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "host/scene/scene.hpp"
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

TEST_F(FreeBodyScene, MayBeAsLightAndAsHeavyAsAServoMoves) {
    EXPECT_EQ(read("[body]\nfree = true\nmass = 1e-6\n").free_body->mass_kg, 1e-6);
    EXPECT_EQ(read("[body]\nfree = true\nmass = 1e6\n").free_body->mass_kg, 1e6);
}

// Only its contacts push it: no force goes on after one.
TEST_F(FreeBodyScene, ContactsAloneActOnIt) {
    const std::string free = "[body]\nfree = true\nmass = 1\n", least = "[contact]\ngod_object = \"least-energy\"\n";
    EXPECT_GT(read(least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(free + least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(free + least + "release_slew = 0\npassivity = false\n").contact.release_n_per_ms, 0.0);
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

TEST_F(FreeBodyScene, MayRingUnderTwoFingers) {
    EXPECT_EQ(read("[body]\nfree = true\nmodes = 2\nmass = 1\n[contact]\nfingers = 2\n").contact.fingers, 2);
}

}  // namespace
}  // namespace haptable
