// SPDX-License-Identifier: GPL-2.0-or-later
// [body] free = true: what it reads.
#include "tests/host/scene/scene_file.hpp"

namespace haptable::test {
namespace {

class FreeBodyScene : public SceneFile {
protected:
    Scene read(const std::string& rest) const {
        return SceneFile::read("name = \"a\"\n[mesh]\ngenerate = \"cube\"\n[material]\nyoung = 1000\npoisson = 0.3\n" +
                               rest);
    }
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
    for (const char* mass_kg : {"1e-6", "1e6"})
        EXPECT_EQ(read(std::string("[body]\nfree = true\nmass = ") + mass_kg).free_body->mass_kg, std::stod(mass_kg));
}

// Only its contacts push it: no force goes on after one. It goes by the least energy unless the scene says otherwise.
TEST_F(FreeBodyScene, ContactsAloneActOnIt) {
    const std::string free = "[body]\nfree = true\nmass = 1\n", least = "[contact]\ngod_object = \"least-energy\"\n";
    EXPECT_GT(read(least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(free + least).contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read(free + least + "release_slew = 0\npassivity = false\n").contact.release_n_per_ms, 0.0);
    EXPECT_EQ(read("").contact.god_object, GodObject::kNearest);
    EXPECT_EQ(read(free).contact.god_object, GodObject::kLeastEnergy);
    EXPECT_EQ(read(free + "[contact]\ngod_object = \"nearest\"\n").contact.god_object, GodObject::kNearest);
}

TEST_F(FreeBodyScene, MayRingHeldOrFree) {
    const Scene held = read("[body]\nmodes = 6\ndensity = 900\nmass = 0.1\n");
    ASSERT_TRUE(held.body_modes);
    EXPECT_FALSE(held.free_body);
    EXPECT_EQ(held.body_modes->modes, 6);
    EXPECT_EQ(held.body_modes->line, 8) << "for codegen's errors";
    EXPECT_EQ(held.body_modes->damping_ratio, 0.05);
    EXPECT_EQ(held.density_of(-1), 900.0);
    EXPECT_EQ(held.mass_kg(), 0.1);
    EXPECT_FALSE(read("[body]\nmodes = 0\n").body_modes);
    const Scene free =
        read("[body]\nfree = true\nmodes = 8\nmode_damping = 0.1\ndensity = 700\nmass = 0.2\n[contact]\nfingers = 2\n");
    ASSERT_TRUE(free.body_modes && free.free_body);
    EXPECT_EQ(free.body_modes->damping_ratio, 0.1);
    EXPECT_EQ(free.density_of(-1), 700.0);
    EXPECT_EQ(free.mass_kg(), 0.2);
    EXPECT_EQ(free.contact.fingers, 2);
}

}  // namespace
}  // namespace haptable::test
