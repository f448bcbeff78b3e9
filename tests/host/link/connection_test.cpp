// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/connection.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "host/base/error.hpp"
#include "host/link/messages.hpp"
#include "tests/environment.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

TEST(Connection, CountsMessagesOfAnotherType) {
    Connection connection("memq://");
    int came = 0;
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state&, std::int64_t) { ++came; });
    connection.publish(channel_of<device_state>(), servo_force{});
    connection.publish(channel_of<device_state>(), device_state{});
    handle_all(connection);
    EXPECT_EQ(came, 1);
    EXPECT_EQ(connection.undecodable(), 1U);
}

TEST(Connection, WaitsForItsDeadline) {
    Connection connection("memq://");
    connection.subscribe<device_state>(channel_of<device_state>(), [](const device_state&, std::int64_t) {});
    const Clock::time_point deadline = Clock::now() + std::chrono::milliseconds(3);
    EXPECT_FALSE(connection.handle_until(deadline));
    EXPECT_GE(Clock::now(), deadline);
    EXPECT_FALSE(connection.handle_until(Clock::now() - std::chrono::seconds(1)));
}

TEST(Connection, SaysWhatToDoWithABadUrl) {
    const std::string said = error_of([&] { Connection connection("nonsense"); });
    EXPECT_TRUE(says(said, "LCM_DEFAULT_URL"));
    EXPECT_EQ(said.find('\n'), std::string::npos);
    for (const char* unguarded : {"mpudpm://239.255.72.84:7684?ttl=0", "tcpq://127.0.0.1:7700"})
        EXPECT_TRUE(fails_with([&] { Connection connection(unguarded); }, "udpm://, memq:// and file://"));
}

TEST(Connection, TakesItsUrlFromTheEnvironment) {
    const Environment address("LCM_DEFAULT_URL", "memq://");
    EXPECT_EQ(lcm_url(), "memq://");
    setenv("LCM_DEFAULT_URL", "", 1);
    EXPECT_EQ(lcm_url(), kDefaultUrl);
    unsetenv("LCM_DEFAULT_URL");
    EXPECT_EQ(lcm_url(), kDefaultUrl);
}

TEST(Connection, HearsOtherMachinesWhereItIsTold) {
    EXPECT_EQ(senders(), Senders::this_machine);
    for (const auto& [word, wanted] : {std::pair{"any", Senders::any}, {"", Senders::this_machine}}) {
        setenv("HAPTABLE_SENDERS", word, 1);
        EXPECT_EQ(senders(), wanted);
    }
    setenv("HAPTABLE_SENDERS", "all", 1);
    EXPECT_THROW(senders(), Error);
    unsetenv("HAPTABLE_SENDERS");
}

// An exception finds no way through liblcm: it comes out behind it, and the connection goes on.
TEST(Connection, WhatAHandlerThrowsComesOut) {
    Connection connection("memq://");
    int came = 0;
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state&, std::int64_t) {
        if (++came == 1) throw Error("the line takes nothing");
    });
    for (int i = 0; i < 3; ++i) connection.publish(channel_of<device_state>(), device_state{});
    EXPECT_THROW(handle_all(connection), Error);
    handle_all(connection);
    EXPECT_EQ(came, 3);
}

}  // namespace
}  // namespace haptable::test
