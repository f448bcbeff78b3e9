// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/log_writer.hpp"

#include <gtest/gtest.h>
#include <lcm/lcm.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>

#include "host/base/error.hpp"
#include "host/link/log_reader.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

std::vector<std::uint8_t> bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

TEST(LogWriter, IsReadBackAsItWas) {
    const WorkFolder folder;
    LogWriter log(folder / "a.lcmlog");
    log.add("HAPTABLE_STATE", bytes_of("one"), 1'700'000'000'000'123);
    log.add("B", bytes_of(""), -5);
    log.finish();
    LogReader reader(folder / "a.lcmlog");
    const auto first = reader.next(), second = reader.next();
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->number, 0);
    EXPECT_EQ(first->utime, 1'700'000'000'000'123);
    EXPECT_EQ(first->channel, "HAPTABLE_STATE");
    EXPECT_EQ(std::string(first->data.begin(), first->data.end()), "one");
    EXPECT_EQ(second->number, 1);
    EXPECT_EQ(second->utime, -5);
    EXPECT_TRUE(second->data.empty());
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.damaged(), 0);
}

// liblcm's own reader, which lcm-logplayer and others use, sees the same.
TEST(LogWriter, IsALogToLiblcm) {
    const WorkFolder folder;
    LogWriter log(folder / "a.lcmlog");
    log.add("CHANNEL", bytes_of("what was said"), 42);
    log.finish();
    lcm_eventlog_t* other = lcm_eventlog_create((folder / "a.lcmlog").c_str(), "r");
    ASSERT_NE(other, nullptr);
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(other);
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->timestamp, 42);
    EXPECT_STREQ(event->channel, "CHANNEL");
    EXPECT_EQ(std::string(static_cast<const char*>(event->data), static_cast<std::size_t>(event->datalen)),
              "what was said");
    lcm_eventlog_free_event(event);
    lcm_eventlog_destroy(other);
}

// A full disk: what was there before stays whole, and it is said.
TEST(LogWriter, AFullDiskLeavesWholeEvents) {
    const WorkFolder folder;
    LogWriter log(folder / "a.lcmlog");
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{200, before.rlim_max};
    const auto old = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &small);
    for (int i = 0; i < 10; ++i) {
        log.add("CHANNEL", bytes_of("twenty bytes of data"), i);
        log.flush();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, old);
    EXPECT_TRUE(log.failed());
    EXPECT_THROW(log.finish(), Error);
    LogReader reader(folder / "a.lcmlog");
    int whole = 0;
    while (reader.next()) ++whole;
    EXPECT_EQ(whole, 3);  // of 55 bytes each
    EXPECT_EQ(reader.damaged(), 0);
}

}  // namespace
}  // namespace haptable::test
