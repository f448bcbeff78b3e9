// SPDX-License-Identifier: GPL-2.0-or-later
// The drawn cube: sharp edges, flat faces; and where a body that nothing holds is. Which patches are held or must not
// be touched picture_test.cpp sees.
#include "host/view/surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "host/view/frame.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

class ViewSurface : public WithCube {};

TEST_F(ViewSurface, SplitsNormalsAtTheEdgesOfTheCubeOnlyAndOutwards) {
    const DrawnSurface surface(tables_);
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
    const Vector3f centre = Vector3f::Constant(0.015F);
    for (std::size_t p = 0; p < surface.patches(); ++p)
        for (int c = 0; c < 3; ++c) {
            const Vector3f& corner = surface.rest_m[std::size_t(surface.patch[p][c])];
            EXPECT_GT(surface.normal[std::size_t(surface.normal_of[p][c])].dot(corner - centre), 0.0F);
        }
}

// Edges of 5 mm are differences of positions of up to 30 mm, and a normal is made of some six patches' cross products.
constexpr Bound kNormal{.count = 16, .epsilon = kFloat, .condition = 30.0 / 5.0};

/// A quarter turn about z.
constexpr std::array<double, 4> kQuarter{std::numbers::sqrt2 / 2.0, 0.0, 0.0, std::numbers::sqrt2 / 2.0};

TEST(ViewPose, TurnsAboutTheCentreOfMass) {
    const auto pose = pose_of({1.0, 0.0, 0.0}, {5.0, 0.0, 0.0}, kQuarter);
    ASSERT_TRUE(pose);
    EXPECT_WITHIN((*pose * Vector3d(1.0, 0.0, 0.0) - Vector3d(5.0, 0.0, 0.0)).norm(), .count = 16);
    EXPECT_WITHIN((*pose * Vector3d(2.0, 0.0, 0.0) - Vector3d(5.0, 1.0, 0.0)).norm(), .count = 16);
    EXPECT_FALSE(pose_of({1.0, 0.0, 0.0}, {NAN, 0.0, 0.0}, kQuarter));
    EXPECT_FALSE(pose_of({1.0, 0.0, 0.0}, {5.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0}));
}

TEST_F(ViewSurface, MovesWithItsNormals) {
    DrawnSurface surface(tables_);
    const std::vector<Vector3f> before = surface.normal;
    const auto pose = pose_of({0.015, 0.015, 0.015}, {0.1, 0.0, 0.0}, kQuarter);
    surface.move(*pose);
    for (std::size_t i = 0; i < surface.nodes(); ++i) {
        const Vector3d drawn = (surface.rest_m[i] + surface.displacement_m[i]).cast<double>();
        EXPECT_WITHIN((drawn - *pose * surface.rest_m[i].cast<double>()).norm(), .count = 16, .epsilon = kFloat,
                      .size = 0.15);
    }
    for (std::size_t i = 0; i < before.size(); ++i)
        EXPECT_WITHIN((surface.normal[i] - pose->linear().cast<float>() * before[i]).norm(), .count = 16,
                      .epsilon = kFloat);
}

TEST_F(ViewSurface, NormalsAreWeightedByAngle) {
    DrawnSurface surface(tables_);
    std::srand(1);
    for (Vector3f& u : surface.displacement_m) u = 0.002F * Vector3f::Random();
    surface.update_normals();
    std::vector<Vector3d> sum(surface.normal.size(), Vector3d::Zero());
    for (std::size_t p = 0; p < surface.patches(); ++p)
        for (int c = 0; c < 3; ++c) {
            const auto at = [&](int corner) -> Vector3d {
                const auto node = std::size_t(surface.patch[p][corner % 3]);
                return (surface.rest_m[node] + surface.displacement_m[node]).cast<double>();
            };
            const Vector3d a = (at(c + 1) - at(c)).normalized(), b = (at(c + 2) - at(c)).normalized();
            sum[std::size_t(surface.normal_of[p][c])] += std::acos(a.dot(b)) * a.cross(b).normalized();
        }
    for (std::size_t s = 0; s < sum.size(); ++s)
        EXPECT_WITHIN((surface.normal[s].cast<double>() - sum[s].normalized()).norm(), kNormal);
}

}  // namespace
}  // namespace haptable::test
