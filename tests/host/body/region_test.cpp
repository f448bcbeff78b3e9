// SPDX-License-Identifier: GPL-2.0-or-later
// Where a body may be touched.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>

#include "host/mesh/cube.hpp"
#include "tests/host/body/cubes.hpp"

namespace haptable {
namespace {

using test::box, test::kCubeSide_m;

/// A cube that is fixed at its bottom.
Scene column_scene(int nodes_per_side) {
    Scene scene = test::cube_of("column", nodes_per_side, {1e4, 0.0});
    scene.fixed.push_back(box(-1, -1, -1, 1, 1, 1e-9));
    return scene;
}

TEST(Touch, AGroupOfTrianglesIsItsTriangles) {
    Scene scene = column_scene(3);
    TetMesh mesh = make_mesh(scene.mesh);
    const Surface surface = find_surface(mesh.tet);
    MeshGroup& group = mesh.group["pad"];
    group.triangle = {surface.patch[0], surface.patch[40]};
    std::swap(group.triangle[1][0], group.triangle[1][1]);  // whichever way round the file has it
    for (const Patch& patch : group.triangle) group.node.insert(group.node.end(), patch.begin(), patch.end());
    scene.touch.push_back({{}, "pad", 3});
    const Body body = make_body(scene, std::move(mesh));
    EXPECT_EQ(body.touch_patch, (std::vector<Patch>{surface.patch[0], surface.patch[40]}));
}

/// A cube of 5 cells a side without the one in its middle.
TetMesh hollow_cube() {
    TetMesh mesh = make_cube(6, kCubeSide_m);
    const auto is_middle = [&](const Tet& tet) {
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        for (std::int32_t i : tet) centre += 0.25 * mesh.position_m[std::size_t(i)];
        return (centre.array() > 0.4 * kCubeSide_m).all() && (centre.array() < 0.6 * kCubeSide_m).all();
    };
    std::erase_if(mesh.tet, is_middle);
    return mesh;
}

TEST(Touch, AnInnerCavityIsTouchedOnlyWhereAsked) {
    Scene scene = column_scene(6);
    const std::size_t outer = 6 * 25 * 2, inner = 6 * 2;
    const auto touchable = [&] { return make_body(scene, hollow_cube()).touch_patch.size(); };
    EXPECT_EQ(touchable(), outer);
    scene.touch = {box(-1, -1, -1, 1, 1, 1)};
    EXPECT_EQ(touchable(), outer);
    scene.touch[0].cavities = true;
    EXPECT_EQ(touchable(), outer + inner);
    scene.touch[0].box_m = {0.005, 0.005, 0.005, 0.025, 0.025, 0.025};
    EXPECT_EQ(touchable(), inner);
}

}  // namespace
}  // namespace haptable
