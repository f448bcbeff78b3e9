// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/touchable.hpp"

#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/tables/npy.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

Touchable touchable(const Shape& shape) { return {shape.point, shape.patch}; }

/// Only the patches whose three corners all are `inside`.
template <typename Inside>
Touchable part_of(const Shape& shape, const Inside& inside) {
    Touchable body{shape.point, {}};
    for (const auto& patch : shape.patch)
        if (std::all_of(patch.begin(), patch.end(),
                        [&](std::int32_t node) { return inside(shape.point[static_cast<std::size_t>(node)]); }))
            body.patch.push_back(patch);
    return body;
}

constexpr Bound kTouched{.count = 32, .size = 0.1};  // positions of up to 0.1 m

TEST(Touchable, TheTopIsPressedStraightDown) {
    const TouchPlace place = top_of(touchable(box_shape(3, Vector3d(0.03, 0.06, 0.1))));
    EXPECT_WITHIN((place.at_m - Vector3d(0.015, 0.03, 0.1)).norm(), kTouched);
    EXPECT_EQ(place.direction, Vector3d(0.0, 0.0, -1.0));
    EXPECT_TRUE(place.is_under_top);
}

// Under the top's centre of a cavity's box there are an inner floor too and the outer bottom: the highest counts.
TEST(Touchable, OfSeveralSurfacesUnderTheTopTheHighestIsTaken) {
    const TouchPlace place = top_of(touchable(hollow_shape(5, 0.05)));
    EXPECT_WITHIN(std::abs(place.at_m.z() - 0.05), kTouched);
}

// A ring's middle is empty: its inner rim is nearest, and is pressed along its own inner normal.
TEST(Touchable, WhereTheMiddleIsEmptyTheNearestPointIsPressedInwards) {
    const Shape ring = torus_shape(24, 12, 0.03, 0.01);
    const TestModel torus(ring);
    const TouchPlace place = top_of(touchable(ring));
    EXPECT_FALSE(place.is_under_top);
    const Vector3d middle(0.0, 0.0, 0.01);  // of the box's top: the shape is symmetric
    // Many points are as near: the distance tells.
    EXPECT_WITHIN(std::abs((place.at_m - middle).norm() - (torus.nearest(middle) - middle).norm()), .count = 64,
                  .epsilon = kFloat, .size = torus.size());
    // From outside, along the direction, the body is ahead.
    EXPECT_GT(torus.signed_solid_angle(place.at_m + 0.003 * place.direction), 6.0);
    EXPECT_LT(torus.signed_solid_angle(place.at_m - 0.003 * place.direction), 6.0);
}

TEST(Touchable, OnlyTheTouchablePartCounts) {
    const Shape box = box_shape(4, Vector3d(0.04, 0.04, 0.04));
    const TouchPlace place = top_of(part_of(box, [](const Vector3d& x) { return x.x() < 1e-9 && x.z() < 0.0301; }));
    EXPECT_WITHIN((place.at_m - Vector3d(0.0, 0.02, 0.03)).norm(), kTouched);
    EXPECT_WITHIN((place.direction - Vector3d::UnitX()).norm(), kTouched);
}

TEST(Touchable, IsReadFromTheTablesAndSaysWhereItIs) {
    const TemporaryFolder folder;
    const std::vector<double> position{0, 0, 0, 0.03, 0, 0.01, 0, 0.02, 0, 0.03, 0.02, 0};
    write_npy<double>(folder.path() / "position.npy", {4, 3}, position);
    write_npy<std::int32_t>(folder.path() / "patch.npy", {2, 3}, std::vector<std::int32_t>{0, 1, 2, 2, 1, 3});
    EXPECT_EQ(where_it_is(read_touchable(folder.path())),
              "the touchable surface lies in (0 0 0) to (0.03 0.02 0.01) m");
    write_npy<std::int32_t>(folder.path() / "patch.npy", {1, 3}, std::vector<std::int32_t>{0, 1, 4});
    EXPECT_THROW(read_touchable(folder.path()), Error);
}

}  // namespace
}  // namespace haptable::test
