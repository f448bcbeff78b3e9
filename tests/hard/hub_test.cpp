// SPDX-License-Identifier: GPL-2.0-or-later
// Many patches at one node.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/finger.hpp"
#include "tests/shapes.hpp"

namespace haptable::test {
namespace {

// The tip is the nearest point of the surface, and some of its patches say "outside" and others "inside": all of them
// have to be asked, from whichever the contact comes.
TEST(HardHub, AFingerThatLeavesOverATipOfThirtyTwoPatchesIsLetGo) {
    constexpr int kSides = HAPTABLE_FAN_PATCHES;
    const TestModel tip(spindle_shape(kSides, 0.005, 0.03));
    const auto at = [&](double side, double radius, double z) {
        const double turn = 2.0 * std::numbers::pi * (side + 0.5) / kSides;
        return Eigen::Vector3d(radius * std::cos(turn), radius * std::sin(turn), z);
    };
    Finger finger(tip);
    for (int from = 0; from < kSides; from += 5)
        for (int to = 0; to < 2 * kSides; ++to) {  // over patches and over the edges between them
            finger.begin();
            finger.to(at(from, 0.002, 0.028));
            finger.to(at(from, 0.0002, 0.028));
            ASSERT_TRUE(finger.touches()) << from;
            finger.to(at(0.5 * to, 0.0005, 0.0301));
            EXPECT_FALSE(finger.touches()) << "from patch " << from << " to patch " << 0.5 * to;
        }
}

}  // namespace
}  // namespace haptable::test
