// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/cube.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "host/mesh/surface.hpp"
#include "tests/error_of.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

double volume(const TetMesh& mesh) {
    double six = 0.0;
    for (const Tet& tet : mesh.tet) six += six_volumes(mesh.position_m, tet);
    return six / 6.0;
}

/// By the divergence theorem: the sum of the signed cones from the origin over an outward surface.
double enclosed_volume(const TetMesh& mesh, const Surface& surface) {
    const auto at = [&](std::int32_t i) -> const Eigen::Vector3d& { return mesh.position_m[std::size_t(i)]; };
    double six = 0.0;
    for (const Patch& p : surface.patch) six += at(p[0]).dot(at(p[1]).cross(at(p[2])));
    return six / 6.0;
}

/// Patches on every directed edge: a closed surface of one orientation has each edge once in either direction.
std::map<std::pair<std::int32_t, std::int32_t>, int> directed_edges(const Surface& surface) {
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    for (const Patch& p : surface.patch)
        for (std::size_t c = 0; c < 3; ++c) ++edges[{p[c], p[(c + 1) % 3]}];
    return edges;
}

class Cube : public testing::TestWithParam<int> {};

TEST_P(Cube, TetrahedraArePositiveAndFillIt) {
    for (double side_m : {1e-3, 0.03, 1e3}) {
        const TetMesh mesh = make_cube(GetParam(), side_m);
        for (const Tet& tet : mesh.tet) ASSERT_GT(six_volumes(mesh.position_m, tet), 0.0);
        // Edges are differences of positions of up to 6 times their size, and so many tetrahedra are added.
        EXPECT_WITHIN(std::abs(volume(mesh) / (side_m * side_m * side_m) - 1.0),
                      .count = 8.0 * std::sqrt(5.0 * 6.0 * 6.0 * 6.0), .condition = 6.0);
    }
}

TEST_P(Cube, IsConformingAndItsSurfaceClosedAndOutward) {
    const int n = GetParam(), cells = n - 1;
    const TetMesh mesh = make_cube(n, 0.03);
    ASSERT_EQ(mesh.position_m.size(), std::size_t(n * n * n));
    ASSERT_EQ(mesh.tet.size(), std::size_t(5 * cells * cells * cells));
    const Surface surface = find_surface(mesh.tet);
    // Diagonals that do not meet would leave single faces inside.
    EXPECT_EQ(surface.patch.size(), std::size_t(12 * cells * cells));
    for (const Patch& patch : surface.patch) {
        const auto side = [&](double plane) {
            const auto at = [&](std::size_t c) { return mesh.position_m[std::size_t(patch[c])].array() == plane; };
            return (at(0) && at(1) && at(2)).any();
        };
        EXPECT_TRUE(side(0.0) || side(0.03));
    }
    const auto edges = directed_edges(surface);
    for (const auto& [edge, count] : edges) {
        ASSERT_EQ(count, 1);
        ASSERT_TRUE(edges.contains({edge.second, edge.first}));
    }
    EXPECT_WITHIN(std::abs(enclosed_volume(mesh, surface) / 2.7e-5 - 1.0), .count = 8.0 * std::sqrt(12.0 * 6.0 * 6.0));
    EXPECT_EQ(surface.joint.size(), (4 * mesh.tet.size() - surface.patch.size()) / 2);
}

INSTANTIATE_TEST_SUITE_P(NodesPerSide, Cube, testing::Range(2, 8));

TEST(PaperCube, IsNumberedAsTheInterfaceSays) {
    const TetMesh mesh = make_cube(3, 2.0);
    EXPECT_EQ(mesh.position_m[0], Eigen::Vector3d(0, 0, 0));
    EXPECT_EQ(mesh.position_m[1], Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(mesh.position_m[3], Eigen::Vector3d(0, 1, 0));
    EXPECT_EQ(mesh.position_m[9], Eigen::Vector3d(0, 0, 1));
    // The corner at the origin belongs to one tetrahedron alone, with its three neighbours along the axes.
    std::vector<Tet> at_origin;
    for (Tet tet : mesh.tet)
        if (std::find(tet.begin(), tet.end(), 0) != tet.end()) at_origin.push_back(tet);
    ASSERT_EQ(at_origin.size(), 1U);
    std::sort(at_origin[0].begin(), at_origin[0].end());
    EXPECT_EQ(at_origin[0], (Tet{0, 1, 3, 9}));
}

TEST(SurfaceOfTets, ADoubledTetrahedronIsAnErrorThatNamesIt) {
    TetMesh mesh = make_cube(2, 1.0);
    mesh.tet.push_back(mesh.tet[4]);  // the one in the middle: its faces are in two tetrahedra already
    const std::string said = test::error_of([&] { find_surface(mesh.tet); });
    EXPECT_TRUE(test::says(said, "share one face"));
    EXPECT_TRUE(test::says(said, "4 and 5"));
}

}  // namespace
}  // namespace haptable
