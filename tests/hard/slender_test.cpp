// SPDX-License-Identifier: GPL-2.0-or-later
// A plate.
#include <gtest/gtest.h>

#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

// A plate is thinner than a finger presses: what holds the finger is the face that it came through, not the nearest
// one.
TEST(HardSlender, AFingerThatIsPushedThroughAPlateStaysOnTheFaceThatItEntered) {
    const ElasticBody plate(plate_cells(6, 0.1, 0.001), "plate", ForceLaw::kInterpolated);
    constexpr double kTop = 0.001, kDeepest = 0.004;
    for (const GodObject god_object : every<GodObject>()) {
        Finger finger(plate.model(god_object));
        double last = 0.0;
        for (int tick = -5; tick <= 40; ++tick) {
            finger.to({0.0503, 0.0487, kTop - 1e-4 * tick});
            if (tick < 1) continue;
            ASSERT_TRUE(finger.touches()) << word(god_object) << " " << 0.1 * tick << " mm";
            EXPECT_WITHIN(std::abs(finger.god().z() - kTop), .count = 4, .epsilon = kFloat, .size = kDeepest);
            EXPECT_GT(finger.force().z(), last) << "deeper is harder";
            last = finger.force().z();
        }
    }
}

}  // namespace
}  // namespace haptable::test
