// SPDX-License-Identifier: GPL-2.0-or-later
// The drawn cube: sharp edges, flat faces, the right patches neutral.
#include "host/view/surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3f;

Tables cube_tables(const CubeOptions& options = {}) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path(), options);
    return read_tables(folder.path());
}

int sum(const std::vector<std::uint8_t>& values) { return std::accumulate(values.begin(), values.end(), 0); }

TEST(ViewSurface, SplitsNormalsAtTheEdgesOfTheCubeOnly) {
    const DrawnSurface surface(cube_tables());
    EXPECT_EQ(surface.nodes(), 98U);
    EXPECT_EQ(surface.patches(), 192U);
    // Each of the 6 faces has 25 nodes with a normal of their own.
    EXPECT_EQ(surface.normal.size(), 150U);
    int creases = 0;
    for (const auto& crease : surface.crease) creases += crease[0] + crease[1] + crease[2];
    EXPECT_EQ(creases, 2 * 12 * 4);  // 12 edges of 4 segments, seen from both sides
    for (const Vector3f& n : surface.normal) {
        EXPECT_WITHIN(std::abs(n.cwiseAbs().maxCoeff() - 1.0F), .count = 32, .epsilon = kFloat);  // along an axis
        EXPECT_WITHIN(std::abs(n.norm() - 1.0F), .count = 32, .epsilon = kFloat);
    }
}

TEST(ViewSurface, NormalsPointOutwards) {
    const DrawnSurface surface(cube_tables());
    const Vector3f centre = Vector3f::Constant(0.015F);
    for (std::size_t p = 0; p < surface.patches(); ++p)
        for (int c = 0; c < 3; ++c) {
            const Vector3f& corner = surface.rest_m[static_cast<std::size_t>(surface.patch[p][c])];
            EXPECT_GT(surface.normal[static_cast<std::size_t>(surface.normal_of[p][c])].dot(corner - centre), 0.0F);
        }
}

// Edges of 5 mm are differences of positions of up to 30 mm, and a normal is made of some six patches' cross products.
constexpr Bound kNormal{.count = 16, .epsilon = kFloat, .condition = 30.0 / 5.0};

TEST(ViewSurface, NormalsFollowTheDeformation) {
    const Tables tables = cube_tables();
    DrawnSurface surface(tables);
    // A turn of the whole body about x: every normal turns with it, also at fixed nodes, which are moved by hand.
    const Eigen::Matrix3f turn = Eigen::AngleAxisf(0.5F, Vector3f::UnitX()).toRotationMatrix();
    const std::vector<Vector3f> before = surface.normal;
    for (std::size_t i = 0; i < surface.nodes(); ++i)
        surface.displacement_m[i] = turn * surface.rest_m[i] - surface.rest_m[i];
    surface.update_normals();
    for (std::size_t i = 0; i < before.size(); ++i)
        EXPECT_WITHIN((surface.normal[i] - turn * before[i]).norm(), kNormal);
}

TEST(ViewSurface, NormalsAreWeightedByAngle) {
    DrawnSurface surface(cube_tables());
    std::srand(1);
    for (Vector3f& u : surface.displacement_m) u = 0.002F * Vector3f::Random();
    surface.update_normals();
    std::vector<Eigen::Vector3d> sum(surface.normal.size(), Eigen::Vector3d::Zero());
    for (std::size_t p = 0; p < surface.patches(); ++p)
        for (int c = 0; c < 3; ++c) {
            const auto at = [&](int corner) -> Eigen::Vector3d {
                const auto node = static_cast<std::size_t>(surface.patch[p][corner % 3]);
                return (surface.rest_m[node] + surface.displacement_m[node]).cast<double>();
            };
            const Eigen::Vector3d a = (at(c + 1) - at(c)).normalized(), b = (at(c + 2) - at(c)).normalized();
            sum[static_cast<std::size_t>(surface.normal_of[p][c])] += std::acos(a.dot(b)) * a.cross(b).normalized();
        }
    for (std::size_t s = 0; s < sum.size(); ++s)
        EXPECT_WITHIN((surface.normal[s].cast<double>() - sum[s].normalized()).norm(), kNormal);
}

TEST(ViewSurface, FixedNodesStay) {
    const Tables tables = cube_tables();
    DrawnSurface surface(tables);
    const std::vector<float> all_one(3 * tables.row_id.size(), 1.0F);
    surface.deform(all_one);
    for (std::size_t i = 0; i < surface.nodes(); ++i)
        EXPECT_EQ(surface.displacement_m[i], surface.rest_m[i].z() > 0.0F ? Vector3f::Ones() : Vector3f::Zero());
}

TEST(ViewSurface, FixedAndUntouchablePatchesAreNeutral) {
    const DrawnSurface all(cube_tables());
    EXPECT_EQ(sum(all.neutral), 32);  // the bottom
    EXPECT_EQ(sum(all.touchable), 192);
    const DrawnSurface upper(cube_tables({.touch_above_m = 0.0149}));
    EXPECT_EQ(sum(upper.touchable), 32 + 4 * 16);  // the top and the upper half of the sides
    EXPECT_EQ(sum(upper.neutral), 32 + 4 * 16);
}

TEST(ViewSurface, NeighboursShareAnEdge) {
    const DrawnSurface surface(cube_tables());
    for (std::size_t p = 0; p < surface.patches(); ++p)
        for (int c = 0; c < 3; ++c) {
            const int other = surface.neighbour[p][c];
            ASSERT_GE(other, 0);  // the cube is closed
            const Eigen::Vector3i& q = surface.patch[static_cast<std::size_t>(other)];
            EXPECT_TRUE((q.array() == surface.patch[p][(c + 1) % 3]).any());
            EXPECT_TRUE((q.array() == surface.patch[p][(c + 2) % 3]).any());
        }
}

}  // namespace
}  // namespace haptable::test
