// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene says about parts of a body: materials, and where it may be touched.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>

#include "host/base/error.hpp"
#include "host/body/assembly.hpp"
#include "host/mesh/shells.hpp"
#include "tests/conditioning.hpp"
#include "tests/host/body/cubes.hpp"

namespace haptable {

namespace {

using test::box, test::kCubeSide_m;

/// A cube that is fixed at its bottom; without lateral strain it is a bundle of springs.
Scene column_scene(int nodes_per_side) {
    Scene scene = test::cube_of("column", nodes_per_side, {1e4, 0.0});
    scene.fixed.push_back(box(-1, -1, -1, 1, 1, 1e-9));
    return scene;
}

/// Nodal forces of a pressure on the top: a third of the pressure on each patch at each of its corners, downwards.
Eigen::VectorXd top_pressure(const Body& body, double pressure_pa) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(body.free_node.size()));
    const auto at = [&](std::int32_t i) { return body.mesh.position_m[static_cast<std::size_t>(i)]; };
    for (const Patch& p : body.surface.patch) {
        if (std::any_of(p.begin(), p.end(), [&](auto i) { return at(i).z() < kCubeSide_m * 0.999; })) continue;
        const double area_m2 = 0.5 * (at(p[1]) - at(p[0])).cross(at(p[2]) - at(p[0])).norm();
        for (std::int32_t i : p)
            force[3 * body.unknown[static_cast<std::size_t>(i)] + 2] -= pressure_pa * area_m2 / 3.0;
    }
    return force;
}

TEST(Region, LayersAreSpringsInSeries) {
    Scene scene = column_scene(5);
    const double quarter = kCubeSide_m / 4;
    scene.regions.push_back({box(-1, -1, 0, 1, 1, quarter), {5e4, 0.0}});
    scene.regions.push_back({box(-1, -1, 2 * quarter, 1, 1, 3 * quarter), {2e3, 0.0}});
    const Body body = make_body(scene, make_mesh(scene.mesh));
    const Eigen::SparseMatrix<double> k = assemble_free(scene, body).matrix();
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(k);
    const Eigen::VectorXd u = factor.solve(top_pressure(body, 100.0));
    const double expected_m = -100.0 * quarter * (1 / 5e4 + 1 / 1e4 + 1 / 2e3 + 1 / 1e4);
    int tops = 0;
    for (std::int32_t i : body.free_surface_node) {
        if (body.mesh.position_m[static_cast<std::size_t>(i)].z() < kCubeSide_m * 0.999) continue;
        const double moved_m = u[3 * body.unknown[static_cast<std::size_t>(i)] + 2];
        EXPECT_WITHIN(std::abs(moved_m / expected_m - 1.0), test::inverse_bound(k));
        ++tops;
    }
    EXPECT_EQ(tops, 25);
}

TEST(Region, TwoThatShareATetrahedronAndOneWithoutAnyAreErrors) {
    Scene scene = column_scene(3);
    scene.regions.push_back({box(-1, -1, -1, 1, 1, 1), {5e4, 0.0}});
    scene.regions.push_back({box(-1, -1, 0.0, 1, 1, 0.01), {2e3, 0.0}});
    EXPECT_THROW(make_body(scene, make_mesh(scene.mesh)), Error);
    scene.regions = {{box(1, 1, 1, 2, 2, 2), {5e4, 0.0}}};
    EXPECT_THROW(make_body(scene, make_mesh(scene.mesh)), Error);
    scene.regions = {{{{}, "nodule", 7}, {5e4, 0.0}}};
    EXPECT_THROW(make_body(scene, make_mesh(scene.mesh)), Error);
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
    MeshSource source;
    source.generate = "cube";
    source.nodes_per_side = 6;
    source.side_m = kCubeSide_m;
    TetMesh mesh = make_mesh(source);
    const auto is_middle = [&](const Tet& tet) {
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        for (std::int32_t i : tet) centre += 0.25 * mesh.position_m[static_cast<std::size_t>(i)];
        return (centre.array() > 0.4 * kCubeSide_m).all() && (centre.array() < 0.6 * kCubeSide_m).all();
    };
    std::erase_if(mesh.tet, is_middle);
    return mesh;
}

TEST(Touch, AnInnerCavityIsTouchedOnlyWhereAsked) {
    Scene scene = column_scene(6);
    const std::size_t outer = 6 * 25 * 2, inner = 6 * 2;
    const TetMesh mesh = hollow_cube();
    const Surface surface = find_surface(mesh.tet);
    EXPECT_EQ(find_shells(mesh, surface, edges_of(surface.patch)).volume_m3.size(), 2U);
    EXPECT_EQ(make_body(scene, hollow_cube()).touch_patch.size(), outer);
    scene.touch = {box(-1, -1, -1, 1, 1, 1)};
    EXPECT_EQ(make_body(scene, hollow_cube()).touch_patch.size(), outer);
    scene.touch[0].cavities = true;
    EXPECT_EQ(make_body(scene, hollow_cube()).touch_patch.size(), outer + inner);
    scene.touch[0].box_m = {0.005, 0.005, 0.005, 0.025, 0.025, 0.025};
    EXPECT_EQ(make_body(scene, hollow_cube()).touch_patch.size(), inner);
}

}  // namespace

}  // namespace haptable
