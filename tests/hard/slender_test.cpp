// SPDX-License-Identifier: GPL-2.0-or-later
// Needles and plates, along the axes and askew.
#include "host/hard/measure.hpp"
#include "tests/finger.hpp"
#include "tests/hard/holds.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

TEST(HardSlender, Needle) {
    expect_holds("needle 1:100");
    expect_holds("needle 1:100, askew");
    expect_holds("needle 1:100 of steel, askew");
}

TEST(HardSlender, Plate) {
    expect_holds("plate 1:100");
    expect_holds("plate 1:100, askew");
}

// A plate is thinner than a finger presses: what holds the finger is the face that it came through, not the nearest
// one.
TEST(HardSlender, AFingerThatIsPushedThroughAPlateStaysOnTheFaceThatItEntered) {
    const TemporaryFolder folder;
    const HardBody plate(hard_case("plate 1:100", folder.path()), ForceLaw::kInterpolated, folder.path() / "out");
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
