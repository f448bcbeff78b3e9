// SPDX-License-Identifier: GPL-2.0-or-later
// Contact messages from LCM logs that are written here, and live.
#include "host/view/contact_messages.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "host/base/file.hpp"
#include "host/link/connection.hpp"
#include "host/link/log_writer.hpp"
#include "host/link/messages.hpp"
#include "tests/environment.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

class ViewContactMessages : public WithCube {
protected:
    contact message(std::int64_t utime, std::int64_t seq) const {
        contact m{};
        m.utime = utime;
        m.seq = seq;
        m.model_hash = static_cast<std::int64_t>(loads_.tables_hash());
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
                   std::size_t cut = 0) const {
        std::vector<std::pair<std::string, contact>> on_channel;
        for (const contact& m : messages) on_channel.emplace_back(channel, m);
        write_log(on_channel, cut);
    }
    void write_log(const std::vector<std::pair<std::string, contact>>& messages, std::size_t cut = 0) const {
        LogWriter log(log_);
        for (const auto& [channel, m] : messages) add(log, channel, m, cut);
    }
    template <typename Message>
    static void add(LogWriter& log, const std::string& channel, const Message& m, std::size_t cut = 0) {
        const std::vector<std::uint8_t> bytes = encoded(m);
        log.add(channel, std::span(bytes).first(bytes.size() - cut), m.utime + 12345);  // not the time that counts
    }

    std::vector<ContactFrame> frames(int every_ms) const {
        return read_contact_log(log_, loads_, {.every_ms = every_ms, .ticks = {}}).frames;
    }
    std::string error_of(const FrameChoice& choice = {}) const {
        return test::error_of([&] { read_contact_log(log_, loads_, choice); });
    }
    /// Without what it touches.
    static contact silent(contact m) {
        m.count = m.touches = 0;
        m.node.clear();
        m.force_n.clear();
        return m;
    }

    const std::filesystem::path log_ = folder_.path() / "session.log";
    const ContactLoads loads_{tables_};
};

TEST_F(ViewContactMessages, AMessageBecomesAFrame) {
    const ContactFrame frame = to_frame(message(2'500'000, 7), loads_, 500'000, "test");
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
    const ContactFrame frame = to_frame(left, loads_, 0, "test");
    EXPECT_FALSE(frame.contact);
    EXPECT_EQ(frame.loads, to_frame(message(0, 0), loads_, 0, "test").loads);
}

// A body that rings is drawn as far as its own servo has said that it swung, in contact or not.
TEST_F(ViewContactMessages, AFrameHasTheModesThatItsServoTold) {
    {
        LogWriter log(log_);
        for (int tick = 0; tick < 3; ++tick) {
            body_modes modes{};
            modes.servo = tick == 2 ? 99 : 0;
            modes.count = 2;
            modes.swung[0] = 0.5F * float(tick);
            add(log, channel_of<body_modes>(), modes);
            const contact m = message(1000 * tick, tick);
            add(log, channel_of<contact>(), tick == 1 ? silent(m) : m);
        }
    }
    const auto drawn = frames(1);
    ASSERT_EQ(drawn.size(), 3U);
    EXPECT_EQ(drawn[0].modes, (std::vector<float>{0.0F, 0.0F}));
    EXPECT_EQ(drawn[1].modes, (std::vector<float>{0.5F, 0.0F}));
    EXPECT_TRUE(drawn[2].modes.empty()) << "of another servo";
}

TEST_F(ViewContactMessages, AFrameShowsTheNewestMessageOfItsTime) {
    std::vector<contact> messages;
    for (int k = 0; k < 100; ++k)
        if (k < 40 || k > 75) messages.push_back(message(1'000'000 + 1000 * k, k));  // a gap of 36 ms
    write_log(messages);
    const auto drawn = frames(10);
    const std::vector<std::int64_t> expected{0, 10, 20, 30, 39, 39, 39, 39, 80, 90};
    ASSERT_EQ(drawn.size(), expected.size());
    for (std::size_t i = 0; i < drawn.size(); ++i) {
        EXPECT_EQ(drawn[i].number, expected[i]);
        EXPECT_WITHIN(std::abs(drawn[i].time_s - 0.01 * double(i)), .count = 4, .size = 0.1);
    }
}

// Messages of one time are one tick; a finger that says nothing more is where it was, until it is silent.
TEST_F(ViewContactMessages, TwoFingersAreOneFrame) {
    const auto second = [this](std::int64_t utime, std::int64_t seq) {
        contact m = message(utime, seq);
        m.finger_m[0] = 0.02;
        m.node = {87, 88};
        return std::pair(channel_of<contact>(1), m);
    };
    const auto first = [this](std::int64_t utime, std::int64_t seq) {
        return std::pair(channel_of<contact>(), message(utime, seq));
    };
    write_log({first(0, 0),
               second(0, 50),
               first(1000, 1),
               second(2000, 51),
               {channel_of<contact>(1), silent(second(3000, 52).second)},
               first(4000, 4)});
    const auto drawn = frames(1);
    ASSERT_EQ(drawn.size(), 5U);
    EXPECT_EQ(drawn[0].number, 0);
    for (std::size_t i = 0; i < 4; ++i) {
        ASSERT_FALSE(drawn[i].others.empty()) << i;
        EXPECT_EQ(drawn[i].others[0].finger_m[0], 0.02);
        EXPECT_EQ(drawn[i].others[0].contact, i < 3) << "silent, it touches nothing, and is where it is";
    }
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(drawn[i].others[0].force_n[2], -3.5);
        EXPECT_EQ(drawn[i].finger_m[0], 0.0);
        ASSERT_EQ(drawn[i].loads.size(), 4U);
        EXPECT_EQ(drawn[i].loads[0].node, 112);
        EXPECT_EQ(drawn[i].loads[3].node, 88);
    }
    EXPECT_EQ(drawn[4].loads.size(), 2U);
}

TEST_F(ViewContactMessages, ASecondFingerAloneIsAFrame) {
    write_log({message(0, 0), message(1000, 1)}, channel_of<contact>(1));
    const auto drawn = frames(1);
    ASSERT_EQ(drawn.size(), 2U);
    EXPECT_TRUE(drawn[1].contact && drawn[1].others.empty());
}

TEST_F(ViewContactMessages, ALongPauseAndANewSessionAreCutOut) {
    write_log({message(0, 0), message(10'000, 1), message(100'000'000, 2), message(100'010'000, 3), message(5000, 4),
               message(15'000, 5)});
    const auto drawn = frames(10);
    EXPECT_LT(drawn.size(), 10U);
    EXPECT_EQ(drawn.front().number, 0);
    EXPECT_EQ(drawn.back().number, 5);
    for (std::size_t i = 1; i < drawn.size(); ++i) EXPECT_GT(drawn[i].time_s, drawn[i - 1].time_s);
}

TEST_F(ViewContactMessages, PicksMessagesBySeq) {
    write_log({message(0, 10), message(1000, 11), message(2000, 12)});
    const auto picked = read_contact_log(log_, loads_, {.every_ms = 33, .ticks = {11}}).frames;
    ASSERT_EQ(picked.size(), 1U);
    EXPECT_EQ(picked[0].number, 11);
    EXPECT_TRUE(says(error_of({.every_ms = 33, .ticks = {13}}), "seq 13"));
}

TEST_F(ViewContactMessages, ErrorsNameTheLog) {
    EXPECT_EQ(error_of().rfind(log_.string(), 0), 0U);  // there is none
    write_file(log_, "no log at all");
    EXPECT_TRUE(says(error_of(), "is not an LCM log"));
    write_log({message(0, 0)}, "OTHER_CHANNEL");
    EXPECT_TRUE(says(error_of(), "holds no message on HAPTABLE_CONTACT"));
    write_log({message(0, 0)}, channel_of<contact>(), 5);
    EXPECT_TRUE(says(error_of(), "damaged"));
    contact other = message(0, 0);
    other.model_hash = 5;
    write_log({other});
    EXPECT_TRUE(says(error_of(), "is of the tables 0000000000000005"));
    EXPECT_TRUE(says(error_of(), fmt::format("{:016x}", loads_.tables_hash())));
    write_log({message(0, 0)});
    std::string bytes = read_file(log_);
    bytes[28 + std::string(channel_of<contact>()).size()] ^= 1;  // of the hash of the type's fields
    write_file(log_, bytes);
    EXPECT_TRUE(says(error_of(), "of another version of haptable"));
}

TEST_F(ViewContactMessages, LeavesOutWhatIsDamagedInALog) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
    std::vector<contact> messages;
    for (int k = 0; k < 9; ++k) messages.push_back(message(10'000 * k, k));
    messages[1].node[0] = 125;
    messages[2].force_n[1][2] = kNan;
    messages[3].god_object_m[0] = kInf;
    messages[4].model_hash ^= 1;
    messages[5].utime = std::numeric_limits<std::int64_t>::min();
    messages[6].utime = std::numeric_limits<std::int64_t>::max();
    messages[7].felt_n[1] = kInf;
    write_log(messages);
    const RecordedContacts recorded = read_contact_log(log_, loads_, {.every_ms = 10, .ticks = {}});
    EXPECT_EQ(recorded.left_out, 7);
    ASSERT_EQ(recorded.frames.size(), 9U);
    for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(recorded.frames[i].number, 0);
    EXPECT_EQ(recorded.frames[8].number, 8);
}

// Live: of a servo that sends every millisecond, what is damaged and a second servo between.
TEST_F(ViewContactMessages, FollowsOneServoAndLeavesOutTheRest) {
    const std::string url = own_url();
    if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << "no multicast here: " << why;
    const Environment address("LCM_DEFAULT_URL", url);
    Connection sender(url);
    std::atomic<bool> stop = false;
    std::thread servo([&] {
        for (std::int64_t seq = 0; !stop; ++seq) {
            contact damaged = message(1000 * seq, seq), second = damaged;
            damaged.node[0] = -1;
            sender.publish(channel_of<contact>(), damaged);
            sender.publish(channel_of<contact>(), servo_force{});
            sender.publish(channel_of<contact>(), message(1000 * seq, seq));
            second.servo = 99;
            second.finger_m[0] = 1.0;
            sender.publish(channel_of<contact>(), second);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    });
    std::vector<ContactFrame> drawn;
    FollowedContacts followed{};
    EXPECT_NO_THROW(followed = follow_contacts(loads_, {.frames = 4, .seconds = 20.0},
                                               [&](const ContactFrame& frame) { drawn.push_back(frame); }));
    stop = true;
    servo.join();
    ASSERT_EQ(drawn.size(), 4U);
    for (const ContactFrame& frame : drawn) EXPECT_EQ(frame.finger_m[0], 0.0);
    for (std::size_t i = 1; i < drawn.size(); ++i) EXPECT_GT(drawn[i].number, drawn[i - 1].number);
    EXPECT_GT(followed.messages, 4);
    EXPECT_GE(followed.left_out, 3 * (followed.messages - 1));
    EXPECT_LE(followed.left_out, 3 * (followed.messages + 1));
}

}  // namespace
}  // namespace haptable::test
