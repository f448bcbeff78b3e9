// SPDX-License-Identifier: GPL-2.0-or-later
// A message of every channel of the list, sent over LCM: haptable-run's log has its bytes, and the viewer draws of it
// what is the viewer's. Python reads such a log in tests/loop/test_run.py.
#include "host/run/recorder.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "host/link/log_reader.hpp"
#include "host/view/contact_messages.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

class RecordedList : public testing::Test {
protected:
    void SetUp() override {
        write_cube_tables(folder_ / "cube");
        tables_ = read_tables(folder_ / "cube");
    }
    /// As a servo of these tables sends it, of the tick 7.
    template <typename Message>
    void fill(Message& message) const {
        message.utime = 1'000'000;
        if constexpr (requires { message.seq; }) message.seq = 7;
        message.session = 3;
        if constexpr (requires { message.model_hash; }) message.model_hash = std::int64_t(tables_.tables_hash);
        if constexpr (requires { message.servo; }) message.servo = 5;
        if constexpr (std::is_same_v<Message, body_pose>) {
            message.turn[0] = 1.0;
            message.centre_m[2] = 0.25;
        } else if constexpr (std::is_same_v<Message, body_modes>) {
            message.count = 2;
            message.swung[1] = 0.75F;
        } else if constexpr (std::is_same_v<Message, contact>) {
            message.touches = 1;
            message.finger_m[2] = 0.028;
            message.god_object_m[2] = 0.03;
            message.count = 1;
            message.node = {112};
            message.force_n = {{0.0, 0.0, -1.0}};
        } else if constexpr (std::is_same_v<Message, servo_force>) {
            message.owner = message.session;
        } else if constexpr (std::is_same_v<Message, servo_status>) {
            message.count = 1;
            message.name = {"rejected_positions"};
            message.value = {2};
        }
    }

    WorkFolder folder_;
    Tables tables_;
};

TEST_F(RecordedList, EveryMessageIsInTheLogAndDrawn) {
    Connection connection("memq://");
    std::map<std::string, std::vector<std::uint8_t>> sent;
    std::string line;
    {
        LogWriter log(folder_ / "session.lcmlog");
        Recorder recorder(connection, log);
        each_channel([&]<typename Message>(const char* channel, std::size_t) {
            Message message{};
            fill(message);
            sent[channel] = encoded(message);
            connection.publish(channel, message);
        });
        handle_all(connection);
        EXPECT_EQ(recorder.states(), 2);
        line = recorder.line();
        log.finish();
    }
    EXPECT_GE(sent.size(), 9U);
    EXPECT_TRUE(says(line, " | "));
    EXPECT_TRUE(says(line, "rejected_positions +2"));

    std::map<std::string, std::vector<std::uint8_t>> heard;
    LogReader reader(folder_ / "session.lcmlog");
    while (const auto event = reader.next()) {
        heard[std::string(event->channel)] = {event->data.begin(), event->data.end()};
        EXPECT_EQ(take_message(event->channel, event->data, [](const auto&, std::size_t) {}), Heard::taken);
    }
    EXPECT_EQ(heard, sent);

    // The viewer: all contacts of the tick, where the body was and how far it had swung.
    const ContactLoads loads(tables_);
    const RecordedContacts drawn = read_contact_log(folder_ / "session.lcmlog", loads, {});
    EXPECT_EQ(drawn.left_out, 0);
    ASSERT_EQ(drawn.frames.size(), 1U);
    const ContactFrame& frame = drawn.frames.front();
    EXPECT_EQ(frame.number, 7);
    EXPECT_EQ(frame.others.size(), kFingers - 1);
    EXPECT_EQ(frame.loads.size(), kFingers);
    ASSERT_TRUE(frame.pose.has_value());
    EXPECT_EQ(frame.pose->translation().z(), 0.25);
    EXPECT_EQ(frame.modes, (std::vector<float>{0.0F, 0.75F}));
}

// What another type or another version says on a channel is neither taken nor lost silently.
TEST(MessageList, TellsWhatIsNotItsMessage) {
    std::vector<std::uint8_t> bytes = encoded(body_modes{});
    const auto all = [](const auto&, std::size_t) {};
    EXPECT_EQ(take_message("HAPTABLE_MODES", bytes, all), Heard::taken);
    EXPECT_EQ(take_message("HAPTABLE_BODY", bytes, all), Heard::other_version);
    EXPECT_EQ(take_message("HAPTABLE_MODES_2", bytes, all), Heard::elsewhere);  // it is of the body
    EXPECT_EQ(take_message("HAPTABLE_MODES", bytes, [](const contact&, std::size_t) {}), Heard::elsewhere);
    bytes.pop_back();
    EXPECT_EQ(take_message("HAPTABLE_MODES", bytes, all), Heard::damaged);
    static_assert(Sent<device_state>::kSender == Sender::device && Sent<body_modes>::kSender == Sender::servo);
}

// docs/SPEC.md and README.md list what is sent.
TEST(MessageList, IsThatOfThePages) {
    const std::string spec = read_file("docs/SPEC.md"), readme = read_file("README.md");
    const auto has = [](const std::string& page, const std::string& row) {
        return page.find(row) != std::string::npos;
    };
    each_channel([&]<typename Message>(const char* channel, std::size_t finger) {
        const std::string row = fmt::format("| `{}` | `{}` |", channel, Message::getTypeName());
        if (finger == 0) {
            EXPECT_TRUE(has(spec, row + (Sent<Message>::kSender == Sender::device ? " device" : " servo"))) << row;
            EXPECT_TRUE(has(readme, row)) << row;
        } else if (finger == 1 || finger == kFingers - 1) {
            EXPECT_TRUE(has(spec, fmt::format("`{}`", channel))) << channel;
        }
    });
}

}  // namespace
}  // namespace haptable::test
