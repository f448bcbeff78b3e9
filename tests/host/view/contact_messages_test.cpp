// SPDX-License-Identifier: GPL-2.0-or-later
// Contact messages from LCM logs that are written here, and live.
#include "host/view/contact_messages.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <atomic>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

class ViewContactMessages : public ::testing::Test {
protected:
    ViewContactMessages() {
        write_cube_tables(folder_.path());
        tables_ = read_tables(folder_.path());
        loads_ = std::make_unique<ContactLoads>(tables_);
    }

    contact message(std::int64_t utime, std::int64_t seq) const {
        contact m{};
        m.utime = utime;
        m.seq = seq;
        m.model_hash = static_cast<std::int64_t>(loads_->tables_hash());
        m.finger_m[2] = 0.028;
        m.god_object_m[2] = 0.03;
        m.felt_n[2] = -3.5;
        m.touches = 1;
        m.count = 2;
        m.node = {112, 113};
        m.force_n = {{1.0, 2.0, 3.0}, {-4.0, 0.0, 0.5}};
        return m;
    }

    void write_log(const std::vector<contact>& messages, const std::string& channel = channel_of<contact>(),
                   int cut = 0) const {
        std::vector<std::pair<std::string, contact>> on_channel;
        for (const contact& m : messages) on_channel.emplace_back(channel, m);
        write_log(on_channel, cut);
    }
    void write_log(const std::vector<std::pair<std::string, contact>>& messages, int cut = 0) const {
        lcm::LogFile log(log_.string(), "w");
        for (const auto& [channel, m] : messages) add(log, channel, m, cut);
    }
    template <typename Message>
    static void add(lcm::LogFile& log, const std::string& channel, const Message& m, int cut = 0) {
        std::vector<char> bytes(static_cast<std::size_t>(m.getEncodedSize()));
        m.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
        lcm::LogEvent event{};
        event.timestamp = m.utime + 12345;  // not the time that counts
        event.channel = channel;
        event.data = bytes.data();
        event.datalen = static_cast<int>(bytes.size()) - cut;
        log.writeEvent(&event);
    }

    std::string error_of(const FrameChoice& choice = {}) const {
        return test::error_of([&] { read_contact_log(log_, *loads_, choice); });
    }

    TemporaryFolder folder_;
    std::filesystem::path log_ = folder_.path() / "session.log";
    Tables tables_;
    std::unique_ptr<ContactLoads> loads_;
};

TEST_F(ViewContactMessages, AMessageBecomesAFrame) {
    const ContactFrame frame = to_frame(message(2'500'000, 7), *loads_, 500'000, "test");
    EXPECT_EQ(frame.number, 7);
    EXPECT_EQ(frame.time_s, 2.0);
    EXPECT_TRUE(frame.contact);
    ASSERT_EQ(frame.loads.size(), 2U);
    EXPECT_EQ(frame.loads[1], (NodalForce{113, {-4.0F, 0.0F, 0.5F}}));
    EXPECT_EQ(frame.force_n, Eigen::Vector3d(0.0, 0.0, -3.5)) << "as the servo said, not the reaction of the loads";
}

TEST_F(ViewContactMessages, ADentThatTheFingerLeftIsDrawnWithoutContact) {
    contact left = message(0, 0);
    left.touches = 0;
    const ContactFrame frame = to_frame(left, *loads_, 0, "test");
    EXPECT_FALSE(frame.contact);
    EXPECT_EQ(frame.loads.size(), 2U);
    EXPECT_EQ(frame.loads[1], (NodalForce{113, {-4.0F, 0.0F, 0.5F}}));
}

// A body that rings is drawn as far as its own servo has said that it swung, in contact or not.
TEST_F(ViewContactMessages, AFrameHasTheModesThatItsServoTold) {
    {
        lcm::LogFile log(log_.string(), "w");
        for (int tick = 0; tick < 3; ++tick) {
            body_modes modes{};
            modes.servo = tick == 2 ? 99 : 0;
            modes.count = 2;
            modes.swung[0] = 0.5F * static_cast<float>(tick);
            add(log, channel_of<body_modes>(), modes);
            contact m = message(1000 * tick, tick);
            if (tick == 1) m.count = m.touches = 0, m.node.clear(), m.force_n.clear();
            add(log, channel_of<contact>(), m);
        }
    }
    const auto frames = read_contact_log(log_, *loads_, {.every_ms = 1, .ticks = {}}).frames;
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(frames[0].modes, (std::vector<float>{0.0F, 0.0F}));
    EXPECT_EQ(frames[1].modes, (std::vector<float>{0.5F, 0.0F}));
    EXPECT_TRUE(frames[2].modes.empty()) << "of another servo";
}

TEST_F(ViewContactMessages, RefusesWhatItsServoCannotHaveSent) {
    contact other = message(0, 0);
    other.model_hash = 1;
    EXPECT_THROW(to_frame(other, *loads_, 0, "test"), Error);
    contact far = message(0, 0);
    far.node[0] = 125;
    EXPECT_THROW(to_frame(far, *loads_, 0, "test"), Error);
    contact wild = message(0, 0);
    wild.force_n[1][2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(to_frame(wild, *loads_, 0, "test"), Error);
    contact felt = message(0, 0);
    felt.felt_n[1] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(to_frame(felt, *loads_, 0, "test"), Error);
}

TEST_F(ViewContactMessages, AFrameShowsTheNewestMessageOfItsTime) {
    std::vector<contact> messages;
    for (int k = 0; k < 100; ++k)
        if (k < 40 || k > 75) messages.push_back(message(1'000'000 + 1000 * k, k));  // a gap of 36 ms
    write_log(messages);
    const auto frames = read_contact_log(log_, *loads_, {.every_ms = 10, .ticks = {}}).frames;
    ASSERT_EQ(frames.size(), 10U);
    const std::int64_t expected[10] = {0, 10, 20, 30, 39, 39, 39, 39, 80, 90};
    for (std::size_t i = 0; i < frames.size(); ++i) {
        EXPECT_EQ(frames[i].number, expected[i]);
        EXPECT_WITHIN(std::abs(frames[i].time_s - 0.01 * static_cast<double>(i)), .count = 4, .size = 0.1);
    }
}

// Messages of one time are one tick; a finger that says nothing more is where it was, until it is silent.
TEST_F(ViewContactMessages, TwoFingersAreOneFrame) {
    const auto second = [this](std::int64_t utime, std::int64_t seq) {
        contact m = message(utime, seq);
        m.finger_m[0] = 0.02;
        m.node = {87, 88};
        return m;
    };
    contact silent = second(3000, 52);
    silent.count = silent.touches = 0;
    silent.node.clear();
    silent.force_n.clear();
    write_log({{channel_of<contact>(), message(0, 0)},
               {channel_of<contact>(1), second(0, 50)},
               {channel_of<contact>(), message(1000, 1)},
               {channel_of<contact>(1), second(2000, 51)},
               {channel_of<contact>(1), silent},
               {channel_of<contact>(), message(4000, 4)}});
    const auto frames = read_contact_log(log_, *loads_, {.every_ms = 1, .ticks = {}}).frames;
    ASSERT_EQ(frames.size(), 5U);
    for (std::size_t i = 0; i < 3; ++i) {
        ASSERT_FALSE(frames[i].others.empty()) << i;
        EXPECT_EQ(frames[i].others[0].finger_m[0], 0.02);
        EXPECT_EQ(frames[i].others[0].force_n[2], -3.5);
        EXPECT_EQ(frames[i].finger_m[0], 0.0);
        ASSERT_EQ(frames[i].loads.size(), 4U);
        EXPECT_EQ(frames[i].loads[0].node, 112);
        EXPECT_EQ(frames[i].loads[3].node, 88);
    }
    EXPECT_EQ(frames[0].number, 0);
    ASSERT_FALSE(frames[3].others.empty()) << "it touches nothing, and is where it is";
    EXPECT_FALSE(frames[3].others[0].contact);
    EXPECT_EQ(frames[3].others[0].finger_m[0], 0.02);
    EXPECT_EQ(frames[4].loads.size(), 2U);
}

TEST_F(ViewContactMessages, ASecondFingerAloneIsAFrame) {
    write_log({message(0, 0), message(1000, 1)}, channel_of<contact>(1));
    const auto frames = read_contact_log(log_, *loads_, {.every_ms = 1, .ticks = {}}).frames;
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_TRUE(frames[1].contact);
    EXPECT_TRUE(frames[1].others.empty());
}

TEST_F(ViewContactMessages, ALongPauseAndANewSessionAreCutOut) {
    write_log({message(0, 0), message(10'000, 1), message(100'000'000, 2), message(100'010'000, 3), message(5000, 4),
               message(15'000, 5)});
    const auto frames = read_contact_log(log_, *loads_, {.every_ms = 10, .ticks = {}}).frames;
    EXPECT_LT(frames.size(), 10U);
    EXPECT_EQ(frames.front().number, 0);
    EXPECT_EQ(frames.back().number, 5);
    for (std::size_t i = 1; i < frames.size(); ++i) EXPECT_GT(frames[i].time_s, frames[i - 1].time_s);
}

TEST_F(ViewContactMessages, PicksMessagesBySeq) {
    write_log({message(0, 10), message(1000, 11), message(2000, 12)});
    const auto frames = read_contact_log(log_, *loads_, {.every_ms = 33, .ticks = {11}}).frames;
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].number, 11);
    EXPECT_NE(error_of({.every_ms = 33, .ticks = {13}}).find("seq 13"), std::string::npos);
}

TEST_F(ViewContactMessages, ErrorsNameTheLog) {
    EXPECT_EQ(error_of().rfind(log_.string(), 0), 0U);  // there is none
    write_file(log_, "no log at all");
    EXPECT_NE(error_of().find("is not an LCM log"), std::string::npos);
    write_log({message(0, 0)}, "OTHER_CHANNEL");
    EXPECT_NE(error_of().find("holds no message on HAPTABLE_CONTACT"), std::string::npos) << error_of();
    write_log({message(0, 0)}, channel_of<contact>(), 5);
    EXPECT_NE(error_of().find("damaged"), std::string::npos) << error_of();
    contact other = message(0, 0);
    other.model_hash = 5;
    write_log({other});
    EXPECT_NE(error_of().find("is of the tables 0000000000000005"), std::string::npos) << error_of();
}

// One damaged message costs its frame, not the film.
TEST_F(ViewContactMessages, LeavesOutWhatIsDamagedInALog) {
    std::vector<contact> messages;
    for (int k = 0; k < 8; ++k) messages.push_back(message(10'000 * k, k));
    messages[1].node[0] = 125;
    messages[2].force_n[1][2] = std::numeric_limits<double>::quiet_NaN();
    messages[3].god_object_m[0] = std::numeric_limits<double>::infinity();
    messages[4].model_hash ^= 1;
    messages[5].utime = std::numeric_limits<std::int64_t>::min();
    messages[6].utime = std::numeric_limits<std::int64_t>::max();
    write_log(messages);
    const RecordedContacts recorded = read_contact_log(log_, *loads_, {.every_ms = 10, .ticks = {}});
    EXPECT_EQ(recorded.left_out, 6);
    ASSERT_EQ(recorded.frames.size(), 8U);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(recorded.frames[i].number, 0);
    EXPECT_EQ(recorded.frames[7].number, 7);
}

TEST_F(ViewContactMessages, ALogOfAnEarlierVersionIsRefused) {
    write_log({message(0, 0)});
    std::string bytes = read_file(log_);
    bytes[28 + std::string(channel_of<contact>()).size()] ^= 1;  // of the hash of the type's fields
    write_file(log_, bytes);
    EXPECT_NE(error_of().find("of another version of haptable"), std::string::npos) << error_of();
}

class Live : public ViewContactMessages {
protected:
    void SetUp() override {
        if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << "no multicast here: " << why;
        sender = std::make_unique<Connection>(url);
        setenv("LCM_DEFAULT_URL", url.c_str(), 1);
    }
    void TearDown() override { unsetenv("LCM_DEFAULT_URL"); }
    /// What is drawn of a servo that sends `at(seq)` every millisecond, four frames.
    FollowedContacts follow(const std::function<void(std::int64_t seq)>& send_at) {
        std::atomic<bool> stop = false;
        std::thread servo([&] {
            for (std::int64_t seq = 0; !stop; ++seq) {
                send_at(seq);
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
        });
        FollowedContacts followed{};
        EXPECT_NO_THROW(followed = follow_contacts(*loads_, {.frames = 4, .seconds = 20.0},
                                                   [&](const ContactFrame& frame) { drawn.push_back(frame); }));
        stop = true;
        servo.join();
        return followed;
    }

    std::string url = "udpm://239.255.72.99:" + std::to_string(20000 + getpid() % 20000) + "?ttl=0";
    std::unique_ptr<Connection> sender;
    std::vector<ContactFrame> drawn;
};

TEST_F(Live, FollowsAServo) {
    const FollowedContacts followed =
        follow([this](std::int64_t seq) { sender->publish(channel_of<contact>(), message(1000 * seq, seq)); });
    ASSERT_EQ(drawn.size(), 4U);
    for (std::size_t i = 1; i < drawn.size(); ++i) EXPECT_GT(drawn[i].number, drawn[i - 1].number);
    EXPECT_GT(followed.messages, 4);
    EXPECT_EQ(followed.left_out, 0);
}

TEST_F(Live, LeavesOutWhatIsDamagedAndASecondServo) {
    const FollowedContacts followed = follow([this](std::int64_t seq) {
        contact damaged = message(1000 * seq, seq), second = damaged;
        damaged.node[0] = -1;
        sender->publish(channel_of<contact>(), damaged);
        sender->publish(channel_of<contact>(), servo_force{});
        sender->publish(channel_of<contact>(), message(1000 * seq, seq));
        second.servo = 99;
        second.finger_m[0] = 1.0;
        sender->publish(channel_of<contact>(), second);
    });
    ASSERT_EQ(drawn.size(), 4U);
    for (const ContactFrame& frame : drawn) EXPECT_EQ(frame.finger_m[0], 0.0);
    EXPECT_GE(followed.left_out, 3 * (followed.messages - 1));
}

}  // namespace
}  // namespace haptable::test
