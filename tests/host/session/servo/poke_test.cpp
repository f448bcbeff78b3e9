// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/servo/poke.hpp"

#include <gtest/gtest.h>

#include "tests/error_of.hpp"
#include "tests/finger.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

// The box reaches to 30 mm: pushed 4 mm down at its top, the god-object stays on it and the force is S u.
TEST(Poke, TellsWhatTheFingerFeels) {
    const SoftBox box;
    const Poked end = poke(box.scene(), {Vector3d(0.0151, 0.0142, 0.03), -Vector3d::UnitZ(), 0.004});
    EXPECT_WITHIN((end.finger_m - Vector3d(0.0151, 0.0142, 0.026)).norm(), .count = 1, .size = 0.03);
    EXPECT_WITHIN(std::abs(end.god_object_m.z() - 0.03), rested(box.model()));
    EXPECT_WITHIN(std::abs(end.depth_m - 0.004), rested(box.model()));
    EXPECT_GT(end.force_n.z(), 0.0);
    Vector3d corners_m = Vector3d::Zero();
    for (const std::int32_t node : end.node)
        corners_m += Vector3d(box.model().tables().position.at(std::size_t(node)).data()) / 3.0;
    EXPECT_LT((corners_m - end.god_object_m).norm(), 0.01);
}

TEST(Poke, FindsTheTop) {
    const SoftBox box;
    EXPECT_WITHIN((place_of("top", *box.scene().model) - Vector3d(0.015, 0.015, 0.03)).norm(), .count = 4,
                  .epsilon = kFloat, .size = 0.03);
    // A ring has nothing over its middle: the nearest of its vertices.
    const TestModel torus(torus_shape(24, 12, 0.03, 0.01));
    const Vector3d top = place_of("top", *torus.get());
    EXPECT_WITHIN((torus.nearest(top) - top).norm(), .count = 4, .epsilon = kFloat, .size = torus.size());
    EXPECT_GT(top.z(), 0.0);
    EXPECT_EQ(place_of("0.1,-2e-3,3", *box.scene().model), Vector3d(0.1, -2e-3, 3.0));
    for (const char* text : {"", "bottom", "1,2", "1,2,3,4", "1,2,nan"})
        EXPECT_TRUE(says(error_of([&] { place_of(text, *box.scene().model); }), "top")) << text;
}

TEST(Poke, SaysWhereTheBodyIsThatItMissed) {
    const SoftBox box;
    const auto poke_at = [&](const Vector3d& at_m, const Vector3d& direction, double depth_m = 0.004) {
        return error_of([&] { poke(box.scene(), {at_m, direction, depth_m}); });
    };
    EXPECT_TRUE(says(poke_at(Vector3d(0.1, 0.1, 0.03), -Vector3d::UnitZ()), "(0 0 0) to (0.03 0.03 0.03) m"));
    EXPECT_TRUE(says(poke_at(Vector3d::Zero(), Vector3d::Zero()), "--direction"));
    EXPECT_TRUE(says(poke_at(Vector3d(0.015, 0.015, 0.03), -Vector3d::UnitZ(), 1e6), "--depth: 1e+06 m"));
}

}  // namespace
}  // namespace haptable::test
