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

// By liblcm's own reader, which lcm-logplayer and others use, and by ours.
TEST(LogWriter, IsReadBackAsItWas) {
    const WorkFolder folder;
    const std::tuple<std::string, std::string, std::int64_t> said[] = {
        {"HAPTABLE_STATE", "what was said", 1'700'000'000'000'123}, {"B", "", -5}};
    LogWriter log(folder / "a.lcmlog");
    for (const auto& [channel, data, utime] : said) log.add(channel, bytes_of(data), utime);
    log.finish();
    LogReader reader(folder / "a.lcmlog");
    lcm_eventlog_t* other = lcm_eventlog_create((folder / "a.lcmlog").c_str(), "r");
    ASSERT_NE(other, nullptr);
    for (const auto& [channel, data, utime] : said) {
        lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(other);
        ASSERT_NE(event, nullptr);
        EXPECT_EQ(event->timestamp, utime);
        EXPECT_EQ(event->channel, channel);
        EXPECT_EQ(std::string(static_cast<const char*>(event->data), std::size_t(event->datalen)), data);
        lcm_eventlog_free_event(event);
        const auto ours = reader.next();
        ASSERT_TRUE(ours);
        EXPECT_EQ(ours->utime, utime);
        EXPECT_EQ(ours->channel, channel);
        EXPECT_EQ(std::string(ours->data.begin(), ours->data.end()), data);
    }
    lcm_eventlog_destroy(other);
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.damaged(), 0);
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
