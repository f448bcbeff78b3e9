// SPDX-License-Identifier: GPL-2.0-or-later
// Logs that liblcm writes, and what becomes of them on a disk.
#include "host/link/log_reader.hpp"

#include <gtest/gtest.h>
#include <lcm/lcm.h>

#include "host/base/error.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

class LogReaderTest : public testing::Test {
protected:
    LogReaderTest() {
        lcm_eventlog_t* log = lcm_eventlog_create(file.c_str(), "w");
        for (int i = 0; i < 5; ++i) {
            std::string channel = "CHANNEL_" + std::to_string(i), data(static_cast<std::size_t>(10 * i), 'd');
            lcm_eventlog_event_t event{};
            event.timestamp = 1000 + i;
            event.channellen = static_cast<std::int32_t>(channel.size());
            event.channel = channel.data();
            event.datalen = static_cast<std::int32_t>(data.size());
            event.data = data.data();
            lcm_eventlog_write_event(log, &event);
        }
        lcm_eventlog_destroy(log);
        whole = read_file(file);
    }
    /// The numbers of the events of a log with these bytes.
    std::vector<std::int64_t> read(const std::string& bytes) {
        write_file(file, bytes);
        LogReader reader(file);
        std::vector<std::int64_t> numbers;
        while (const auto event = reader.next()) numbers.push_back(event->number);
        damaged = reader.damaged();
        return numbers;
    }
    /// Where event k begins: each has 28 bytes, 9 of the channel and 10 k of data.
    static std::size_t begin_of(std::size_t k) { return k * (28 + 9) + 10 * k * (k - 1) / 2; }

    WorkFolder folder;
    std::filesystem::path file = folder / "session.log";
    std::string whole;
    std::int64_t damaged = 0;
};

TEST_F(LogReaderTest, ReadsWhatLiblcmWrites) {
    LogReader reader(file);
    for (int i = 0; i < 5; ++i) {
        const auto event = reader.next();
        ASSERT_TRUE(event);
        EXPECT_EQ(event->number, i);
        EXPECT_EQ(event->utime, 1000 + i);
        EXPECT_EQ(event->channel, "CHANNEL_" + std::to_string(i));
        EXPECT_EQ(event->data.size(), std::size_t(10 * i));
    }
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.damaged(), 0);
}

// Whatever a length says, no more is read than there is, and the events behind it are found.
TEST_F(LogReaderTest, PassesOverDamagedLengths) {
    for (const std::size_t field : {20U, 24U})
        for (const char* length : {"\x7F\xFF\xFF\xFF", "\xFF\xFF\xFF\xFF", "\x80\x00\x00\x00"}) {
            std::string bytes = whole;
            bytes.replace(begin_of(2) + field, 4, std::string(length, 4));
            EXPECT_EQ(read(bytes), (std::vector<std::int64_t>{0, 1, 3, 4})) << field;
            EXPECT_EQ(damaged, 1);
        }
}

TEST_F(LogReaderTest, EndsWhereALogWasCutOff) {
    for (std::size_t size = begin_of(4) + 1; size < whole.size(); ++size) {
        EXPECT_EQ(read(whole.substr(0, size)), (std::vector<std::int64_t>{0, 1, 2, 3})) << size;
        EXPECT_EQ(damaged, 1);
    }
}

TEST_F(LogReaderTest, ErrorsNameTheFile) {
    for (const char* bytes : {"", "no log", "\xED\xA1"}) {
        write_file(file, bytes);
        EXPECT_THROW(LogReader{file}, Error);
    }
    EXPECT_THROW(LogReader{folder.path()}, Error);
    EXPECT_THROW(LogReader{folder / "none.log"}, Error);
}

}  // namespace
}  // namespace haptable::test
