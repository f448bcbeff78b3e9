// SPDX-License-Identifier: GPL-2.0-or-later
// precompute() of a body that nothing holds: its tables, body.json, and the C of it.
#include <gtest/gtest.h>

#include "codegen/rigid_body.hpp"
#include "host/base/file.hpp"
#include "host/precompute/precompute.hpp"
#include "host/tables/tables.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

Scene free_cube() {
    Scene scene = test::cube_scene(4, 0.3);
    scene.fixed.clear();
    scene.free_body = FreeBody{};
    scene.free_body->mass_kg = 0.05;
    scene.free_body->stiffness = {1.0, 2.0, 3.0, 4e-3, 5e-3, 6e-3};
    scene.free_body->floor = FreeBody::Floor{-0.001, {0.0, 0.0, 1.0}, 0.3};
    return scene;
}

class FreeBodyTables : public testing::Test {
protected:
    void run(const Scene& scene) {
        Progress quiet(true);
        precompute(scene, folder.path(), quiet);
    }
    test::TemporaryFolder folder;
};

TEST_F(FreeBodyTables, TheServosBodyIsTheScenes) {
    run(free_cube());
    const std::optional<haptable_body> body = read_rigid_body(folder.path());
    ASSERT_TRUE(body);
    EXPECT_EQ(body->mass_kg, 0.05F);
    EXPECT_WITHIN(std::abs(double(body->centre_m[1]) - 0.015), .count = 4, .epsilon = test::kFloat, .size = 0.015);
    EXPECT_WITHIN(std::abs(double(body->inertia_kg_m2[2]) - 0.05 * 0.0009 / 6.0), .count = 4, .epsilon = test::kFloat,
                  .size = 0.05 * 0.0009 / 6.0);
    EXPECT_EQ(body->stiffness_n_per_m[1], 2.0F);
    EXPECT_EQ(body->turn_stiffness_n_m[2], 6e-3F);
    EXPECT_EQ(body->floor_m, -0.001F);
    EXPECT_EQ(body->floor_friction, 0.3F);
    EXPECT_EQ(body->point_count, 8U);
    EXPECT_EQ(body->gravity_m_per_s2[2], 0.0F);
    EXPECT_TRUE(test::says(read_file(folder.path() / "model.c"), "struct haptable_body haptable_cube4nu30_body"));
    EXPECT_TRUE(test::says(read_file(folder.path() / "model.h"), "HAPTABLE_MODEL_BODY"));
    run(test::cube_scene(4, 0.3));  // held, it has nothing of it
    EXPECT_FALSE(read_rigid_body(folder.path()));
    EXPECT_EQ(read_file(folder.path() / "model.h").find("haptable_body"), std::string::npos);
}

// Every node is free, and S is that of the relieved L: a cube that is as soft at all eight of its corners.
TEST_F(FreeBodyTables, StiffnessHasTheCubesSymmetry) {
    run(free_cube());
    const Tables tables = read_tables(folder.path());
    EXPECT_EQ(tables.node_id.size(), 4U * 4U * 4U - 8U);
    double least = HUGE_VAL, most = 0.0;
    for (std::size_t i = 0; i < tables.node_id.size(); ++i) {
        const auto& x = tables.position[std::size_t(tables.node_id[i])];
        const auto at_end = [](double c) { return c < 1e-9 || c > 0.03 - 1e-9; };
        if (!at_end(x[0]) || !at_end(x[1]) || !at_end(x[2])) continue;
        const auto& s = tables.stiffness[i];
        const double trace = s[0] + s[4] + s[8];
        // Cubes of 5 tetrahedra, mirrored: corners are alike in two groups of 4.
        least = std::min(least, trace);
        most = std::max(most, trace);
    }
    EXPECT_LT(most / least, 1.6);
    EXPECT_GT(least, 0.0);
}

}  // namespace
}  // namespace haptable
