// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/error.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

PathOptions tilted() {
    PathOptions options;
    options.at_m = Vector3d(0.01, 0.02, 0.03);
    options.direction = Vector3d(1.0, 2.0, -2.0);
    return options;
}

/// Depth below the touched point along the way into the body, m.
double depth_of(const Vector3d& x, const PathOptions& o) { return (x - o.at_m).dot(o.direction.normalized()); }

constexpr Bound kPlace{.count = 64, .size = 0.05};  // positions of up to 50 mm

class PathTest : public testing::TestWithParam<const char*> {};

TEST_P(PathTest, MovesWithoutJumpsAtItsSpeed) {
    const auto path = scripted_path(GetParam(), tilted());
    const double h = 1e-5;
    for (double t = h; t < path->duration_s() - h; t += 7.3e-4) {
        const Vector3d slope = (path->at(t + h).position_m - path->at(t - h).position_m) / (2.0 * h);
        // The movement's parts meet with a jump of the third derivative, which a difference sees times h: of 60 v /
        // T^2.
        EXPECT_WITHIN((slope - path->at(t).velocity_m_s).norm(), .epsilon = 2e-4) << t;
        // The peak of a minimum-jerk movement is 15/8 of its mean.
        EXPECT_WITHIN(slope.norm() - 1.875 * tilted().speed_m_s, .epsilon = 2e-4) << t;
    }
}

TEST_P(PathTest, BeginsAndEndsAboveTheSurface) {
    const PathOptions options = tilted();
    const auto path = scripted_path(GetParam(), options);
    for (const double t : {-1.0, 0.0, path->duration_s(), path->duration_s() + 1.0}) {
        EXPECT_WITHIN(std::abs(depth_of(path->at(t).position_m, options) + options.clearance_m), kPlace) << t;
        EXPECT_WITHIN(path->at(t).velocity_m_s.norm(), .count = 64, .size = options.speed_m_s) << t;
    }
}

TEST_P(PathTest, ReachesItsDepthAndNoMore) {
    const PathOptions options = tilted();
    const auto path = scripted_path(GetParam(), options);
    double deepest = -1.0;
    for (double t = 0.0; t < path->duration_s(); t += 1e-4)
        deepest = std::max(deepest, depth_of(path->at(t).position_m, options));
    // Looked at every 0.1 ms, of a movement that stays at its end.
    EXPECT_WITHIN(std::abs(deepest - options.depth_m), .epsilon = 1e-9);
}

INSTANTIATE_TEST_SUITE_P(All, PathTest,
                         testing::Values("poke", "drag", "circle", "roll", "poke,drag,circle,tilt,poke"));

TEST(ScriptedPath, CircleKeepsItsRadius) {
    const PathOptions options = tilted();
    const auto path = scripted_path("circle", options);
    const Vector3d centre = options.at_m + options.depth_m * options.direction.normalized();
    double turned = 0.0;
    Vector3d last = Vector3d::Zero();
    for (double t = 0.0; t < path->duration_s(); t += 1e-3) {
        const Vector3d x = path->at(t).position_m;
        if (std::abs(depth_of(x, options) - options.depth_m) > 1e-9) continue;
        EXPECT_WITHIN(std::abs((x - centre).norm() - options.radius_m), .epsilon = 1e-9);
        if (!last.isZero()) turned += (x - last).norm() / options.radius_m;
        last = x;
    }
    EXPECT_WITHIN(std::abs(turned - 2.0 * M_PI), .epsilon = 0.01);
}

TEST(ScriptedPath, DragGoesBothWaysAlong) {
    PathOptions options;
    options.along = Vector3d(0.0, 3.0, 5.0);  // its part along the surface counts
    const auto path = scripted_path("drag", options);
    double low = 0.0, high = 0.0;
    for (double t = 0.0; t < path->duration_s(); t += 1e-3) {
        const Vector3d x = path->at(t).position_m - options.at_m;
        EXPECT_WITHIN(std::abs(x.x()), kPlace);
        low = std::min(low, x.y());
        high = std::max(high, x.y());
    }
    EXPECT_WITHIN(std::abs(high - options.radius_m), .epsilon = 1e-6);
    EXPECT_WITHIN(std::abs(low + options.radius_m), .epsilon = 1e-6);
}

TEST(ScriptedPath, RefusesWhatItCannotDo) {
    PathOptions options;
    for (const char* words : {"prod", "", "poke,,drag"}) EXPECT_THROW(scripted_path(words, options), Error) << words;
    options.direction = Vector3d::Zero();
    EXPECT_THROW(scripted_path("poke", options), Error);
    options.direction = options.along = Vector3d(1.0, 0.0, 0.0);
    EXPECT_THROW(scripted_path("drag", options), Error);
    EXPECT_THROW(recorded_path({}), Error);
}

TEST(RecordedPath, GoesThroughItsPositions) {
    const auto path = recorded_path({{{{0.0, 0.0, 0.0}, 0}}, {{{1e-3, 0.0, 0.0}, 2}}, {{{1e-3, 2e-3, 0.0}, 0}}});
    EXPECT_WITHIN(std::abs(path->duration_s() - 3e-3), .count = 8, .size = 3e-3);
    EXPECT_WITHIN((path->at(0.5e-3).position_m - Vector3d(0.5e-3, 0.0, 0.0)).norm(), .count = 8, .size = 1e-3);
    EXPECT_WITHIN((path->at(0.5e-3).velocity_m_s - Vector3d(1.0, 0.0, 0.0)).norm(), .count = 8, .size = 1.0);
    EXPECT_WITHIN((path->at(2e-3).position_m - Vector3d(1e-3, 2e-3, 0.0)).norm(), .count = 8, .size = 2e-3);
    EXPECT_EQ(path->at(2.5e-3).velocity_m_s, Vector3d::Zero());
    EXPECT_EQ(path->at(-1.0).position_m, path->at(0.0).position_m);
    EXPECT_EQ(path->at(1.0).position_m, path->at(2e-3).position_m);
    EXPECT_EQ(path->at(0.5e-3).buttons, 0U);
    EXPECT_EQ(path->at(1.5e-3).buttons, 2U);
}

}  // namespace
}  // namespace haptable::test
