// SPDX-License-Identifier: GPL-2.0-or-later
// The state machine behind messages: a live session and its replay give the same record, and damaged tables no session.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/base/error.hpp"
#include "host/link/finger_path.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/loop/limited_box.hpp"

namespace haptable::test {
namespace {

/// Down, along, a glitch of the encoder, a grab that is held on the way out and pulls.
FingerTick tick_of(int tick) {
    const double s = tick / 1000.0;
    FingerTick at{{{0.008 + 0.01 * s, 0.013, 0.0305 - 0.004 * std::sin(8.0 * s)}, 0}};
    if (tick == 300) at.position_m[2] -= 0.025;
    if (tick > 370 && tick < 430) at.buttons = HAPTABLE_BUTTON_GRAB;
    return at;
}

TEST(SafetyLoop, AReplayGivesTheRecordOfTheLiveSession) {
    const WorkFolder folder;
    const LimitedBox box;
    std::string path = "x,y,z,buttons\n";
    haptable_counters counters{};
    {
        Connection connection("memq://");
        ServoRecord record(box.scene(), folder / "live.csv");
        LocalStepper stepper(box.scene());
        Session session(stepper, connection, &record);
        for (int tick = 0; tick < 1000; ++tick) {
            const FingerTick at = tick_of(tick);
            device_state state = simulated_state(tick, tick * 1000);
            std::copy(at.position_m.begin(), at.position_m.end(), state.position_m);
            state.buttons = static_cast<std::int32_t>(at.buttons);
            path += fmt::format("{},{},{},{}\n", at.position_m[0], at.position_m[1], at.position_m[2], at.buttons);
            connection.publish(channel_of<device_state>(), state);
            handle_all(connection);
        }
        counters = stepper.report().counters;
        record.finish();
    }
    write_file(folder / "path.csv", path);
    replay(box.scene(), folder / "path.csv", folder / "replayed.csv", true);
    EXPECT_EQ(read_file(folder / "live.csv"), read_file(folder / "replayed.csv"));
    EXPECT_EQ(counters.ticks, 1000U);
    EXPECT_EQ(counters.implausible, 2U);
    EXPECT_GT(counters.limited_ticks, 0U);
    EXPECT_GT(counters.grabbed_ticks, 0U);
}

TEST(SafetyLoop, DamagedTablesBeginNoSession) {
    const WorkFolder folder;
    LimitedBox box;
    box.model().crc ^= 1U;
    Connection connection("memq://");
    EXPECT_THROW(LocalStepper(box.scene()), Error);
    write_file(folder / "path.csv", "x,y,z\n0,0,0\n");
    EXPECT_THROW(replay(box.scene(), folder / "path.csv", folder / "out.csv", true), Error);
}

}  // namespace
}  // namespace haptable::test
