// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/events.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/error_of.hpp"

namespace haptable::test {
namespace {

servo_force answer(std::int64_t seq, std::int8_t state, std::int32_t faults = 0) {
    servo_force force{};
    force.seq = seq;
    force.servo_state = state;
    force.faults = faults;
    return force;
}

TEST(Events, EachIsToldOnce) {
    Events events;
    std::vector<std::string> told;
    const auto note = [&](const servo_force& force) {
        if (const auto event = events.note(force)) told.push_back(*event);
    };
    for (int seq = 0; seq < 100; ++seq) note(answer(seq, seq % 2 == 0 ? servo_force::CONTACT : servo_force::LIMITED));
    ASSERT_EQ(told.size(), 1U);
    for (int seq = 100; seq < 200; ++seq) note(answer(seq, servo_force::FAULTED, 4));
    ASSERT_EQ(told.size(), 2U);
    EXPECT_TRUE(says(told[1], "positions jump"));
    note(answer(200, servo_force::FAULTED, 5));
    ASSERT_EQ(told.size(), 3U) << "another fault";
    note(answer(201, servo_force::FREE));
    note(answer(202, servo_force::FAULTED, 2));
    EXPECT_EQ(told.size(), 4U) << "a fault is told however soon it comes again";
    note(answer(2000, servo_force::LIMITED));
    EXPECT_EQ(told.size(), 5U);
}

}  // namespace
}  // namespace haptable::test
