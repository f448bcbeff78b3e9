// SPDX-License-Identifier: GPL-2.0-or-later
// A body that nothing holds behind a line: where it is, before each tick's force; and a target that does not say.
#include <gtest/gtest.h>

#include <cstring>
#include <optional>

#include "codegen/vibration.hpp"
#include "firmware/haptable_frame_body_pair.h"
#include "host/base/error.hpp"
#include "host/bridge/session.hpp"
#include "host/servo/replay.hpp"
#include "tests/error_of.hpp"
#include "tests/host/bridge/fake_target.hpp"
#include "tests/loop/soft_pair.hpp"
#include "tests/moving_body.hpp"

namespace haptable::test {
namespace {

// Byte for byte as documented, with the CRC that zlib's crc32 gives for these bytes; and read again.
TEST(FrameBody, WritesTheDocumentedBytes) {
    haptable_body_state body{};
    body.position_m[0] = body.turn[0] = 1.0F;
    body.position_m[2] = -2.0F;
    body.velocity_m_per_s[0] = 0.5F;
    body.spin_rad_per_s[2] = 0.25F;
    body.on_floor = 5;
    Bytes bytes(HAPTABLE_FRAME_POSE_BYTES);
    ASSERT_EQ(haptable_frame_write_pose(7, &body, bytes.data()), bytes.size());
    Bytes want(68);
    const Bytes head{0xA5, 0x5A, 56, 8, 7}, crc{0x0A, 0x6C, 0x20, 0xF2};
    std::copy(head.begin(), head.end(), want.begin());
    for (const std::size_t one : {8U, 20U}) want[one + 2] = 0x80, want[one + 3] = 0x3F;
    want[19] = 0xC0;
    want[39] = 0x3F;                   // 0.5
    want[58] = 0x80, want[59] = 0x3E;  // 0.25
    want[60] = 5;
    std::copy(crc.begin(), crc.end(), want.end() - 4);
    EXPECT_EQ(bytes, want);
    haptable_frame whole{HAPTABLE_FRAME_POSE, HAPTABLE_FRAME_POSE_PAYLOAD, 7, bytes.data() + 8};
    haptable_body_state read{};
    ASSERT_EQ(haptable_frame_take_pose(&whole, &read), 1);
    EXPECT_EQ(std::memcmp(&read, &body, sizeof body), 0);
    whole.type = HAPTABLE_FRAME_FORCE;
    EXPECT_EQ(haptable_frame_take_pose(&whole, &read), 0);
    whole = {HAPTABLE_FRAME_POSE, HAPTABLE_FRAME_POSE_PAYLOAD - 1, 7, bytes.data() + 8};
    EXPECT_EQ(haptable_frame_take_pose(&whole, &read), 0);
}

haptable_body loose_cube() {
    haptable_body body = cube_body();
    add_gravity(body);
    add_floor(body, 0.0, 0.3);
    return body;
}

/// What firmware/port/loop_body.c answers; some of it damaged on its way.
class FakeBodyTarget {
public:
    FakeBodyTarget(const haptable_model* model, const haptable_body* body, const Pty& line)
        : model_(model), body_(body), line_(line) {
        haptable_frame_body_init(model, body, &end_);
    }
    void answer() {
        for (const std::uint8_t byte : line_.take()) {
            Bytes answer(HAPTABLE_FRAME_BODY_BYTES);
            answer.resize(haptable_frame_body_take(model_, body_, &end_, byte, answer.data()));
            if (answer.empty()) continue;
            if (without_pose) answer.erase(answer.begin(), answer.begin() + HAPTABLE_FRAME_POSE_BYTES);
            if (damages++ < 3) answer[10] ^= 1;
            line_.put(answer);
        }
    }
    const haptable_counters& counters() const { return end_.servo.counters; }

    bool without_pose = false;
    int damages = 3;

private:
    const haptable_model* model_;
    const haptable_body* body_;
    const Pty& line_;
    haptable_frame_body end_{};
};

/// A terminal of the kernel's; a finger that comes down beside the middle, and pushes.
class BridgeOfABody : public testing::Test {
protected:
    BridgeOfABody() {
        connection.subscribe<servo_force>(kForceChannel,
                                          [this](const servo_force& m, std::int64_t) { answered = m.seq; });
        connection.subscribe<body_pose>(kBodyChannel, [this](const body_pose& m, std::int64_t) { poses.push_back(m); });
    }
    void ask(std::int64_t seq) {
        device_state state = simulated_state(seq, seq * 1000);
        state.position_m[0] = -0.002 + 3e-5 * static_cast<double>(seq);
        state.position_m[1] = 0.013;
        state.position_m[2] = 0.02;
        const Clock::time_point give_up = Clock::now() + std::chrono::seconds(20);
        while (answered != seq && Clock::now() < give_up) {
            connection.publish(kStateChannel, state);
            handle_all(connection);
            target.answer();
            session.take_answers();
            session.watch(Clock::now());
            handle_all(connection);
        }
        ASSERT_EQ(answered, seq);
    }

    const SoftBox box;
    const haptable_body body = loose_cube();
    WorkFolder folder;
    const Pty port;
    Connection connection{"memq://"};
    SerialTarget line{Line::open(port.name(), 2'000'000)};
    haptable_model model = [this] {
        haptable_model of = *box.scene().model;
        of.hash = SoftBox::kHash;
        return of;
    }();
    FakeBodyTarget target{&model, &body, port};
    std::optional<ServoRecord> record{std::in_place, box.scene(), folder / "bridge.csv", 1, true};
    BridgeSession session{box.scene(), connection, line, {.retry = std::chrono::milliseconds(2)}, &*record, {}, &body};
    std::int64_t answered = -1;
    std::vector<body_pose> poses;
};

// It is where the host's servo has it; an answer whose pose is damaged is none, and is asked for again.
TEST_F(BridgeOfABody, IsWhereTheHostHasIt) {
    for (std::int64_t seq = 0; seq < 300; ++seq) {
        if (seq == 50) target.damages = 0;
        ASSERT_NO_FATAL_FAILURE(ask(seq));
    }
    EXPECT_EQ(target.counters().ticks, 300U) << "stepped once";
    EXPECT_GE(session.report().resent_frames, 3);
    ASSERT_EQ(poses.size(), 300U);
    EXPECT_EQ(poses.back().seq, 299);
    EXPECT_EQ(poses.back().utime, 299000);
    EXPECT_EQ(poses.back().session, kSession);
    EXPECT_EQ(poses.back().rest_centre_m[2], double{body.centre_m[2]});
    EXPECT_GT(poses.back().centre_m[0], poses[0].centre_m[0] + 1e-3) << "it is pushed";
    record->finish();
    const ServoScene scene = box.scene();
    replay(scene, folder / "bridge.csv", folder / "host.csv", true, &body);
    EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
}

// An image of the same tables that knows no body that moves is found out before its forces reach anybody.
TEST_F(BridgeOfABody, ATargetThatDoesNotSayWhereItIsIsAnError) {
    target.without_pose = true;
    const std::string said = error_of([&] { ask(0); });
    EXPECT_NE(said.find("flash the scene's loop_body"), std::string::npos) << said;
    EXPECT_EQ(answered, -1);
}

// One that rings: how far its modes have swung comes before the force; an answer without it is none.
TEST(BridgeOfAJelly, RingsAsTheHostHasIt) {
    const SoftBox box;
    const Pty port;
    WorkFolder folder;
    haptable_model model = *box.scene().model;
    ServoVibration vibration{{tick_of_mode(60.0, 0.05), tick_of_mode(140.0, 0.05)}, {}, 3};
    for (std::size_t k = 0; k < std::size_t{2} * model.free_count; ++k) vibration.shape.push_back({0.0F, 2.0F, 4.0F});
    const haptable_modes modes = vibration_in_memory(vibration, model);
    ServoScene scene = box.scene();
    scene.modes = &modes;
    Connection connection("memq://");
    SerialTarget line(Line::open(port.name(), 2'000'000));
    std::optional<ServoRecord> record{std::in_place, scene, folder / "bridge.csv"};
    BridgeSession session(scene, connection, line, {.retry = std::chrono::milliseconds(2)}, &*record);
    std::int64_t answered = -1;
    std::vector<body_modes> swung;
    connection.subscribe<servo_force>(kForceChannel, [&](const servo_force& m, std::int64_t) { answered = m.seq; });
    connection.subscribe<body_modes>(kModesChannel, [&](const body_modes& m, std::int64_t) { swung.push_back(m); });
    haptable_frame_modes end{};
    haptable_frame_modes_init(&modes, &end);
    int damages = 0;
    const Clock::time_point give_up = Clock::now() + std::chrono::seconds(20);
    for (std::int64_t seq = 0; seq < 200; ++seq) {
        device_state state = simulated_state(seq, seq * 1000);
        state.position_m[0] = state.position_m[1] = 0.013;
        state.position_m[2] = seq < 150 ? 0.031 - 2e-5 * static_cast<double>(seq) : 0.033;
        while (answered != seq && Clock::now() < give_up) {
            connection.publish(kStateChannel, state);
            handle_all(connection);
            for (const std::uint8_t byte : port.take()) {
                Bytes answer(HAPTABLE_FRAME_RINGING_BYTES);
                answer.resize(haptable_frame_modes_take(&modes, &end, byte, answer.data()));
                if (!answer.empty() && seq == 120 && damages++ < 3) answer[9] ^= 1;
                if (!answer.empty()) port.put(answer);
            }
            session.take_answers();
            session.watch(Clock::now());
            handle_all(connection);
        }
        ASSERT_EQ(answered, seq);
    }
    EXPECT_EQ(end.servo.counters.ticks, 200U) << "stepped once";
    EXPECT_GE(session.report().resent_frames, 3);
    ASSERT_EQ(swung.size(), 200U);
    EXPECT_EQ(swung.back().count, 2);
    EXPECT_EQ(swung.back().seq, 199);
    EXPECT_EQ(swung.back().swung[1], end.state.swings.q[1]);
    EXPECT_NE(swung.back().swung[0], 0.0F);
    record->finish();
    replay(scene, folder / "bridge.csv", folder / "host.csv", true);
    EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
    // Of another number of modes, or of no whole number: no frame of ours.
    Bytes frame(HAPTABLE_FRAME_MODES_BYTES);
    haptable_swings read{};
    haptable_frame whole{HAPTABLE_FRAME_MODES, 8, 1, frame.data()};
    EXPECT_EQ(haptable_frame_take_modes(&whole, &read), 2);
    for (const std::uint8_t length : Bytes{7, 68, 88}) {
        whole.length = length;
        EXPECT_EQ(haptable_frame_take_modes(&whole, &read), 0);
    }
}

// Two fingers on a line, one of them away, and the question whether there are two; poses are of the tick before it.
TEST(FrameBodyPair, MovesItAsASessionDoes) {
    const SoftPair two(0.5);
    const ServoScene scene = two.scene();
    const haptable_body body = loose_cube();
    haptable_frame_body_pair line{};
    haptable_frame_body_pair_init(scene.pair, &body, &line);
    Fingers session(scene, &body);
    haptable_frame_reader reader{};
    haptable_frame_reader_init(&reader);
    const auto put = [&](const Bytes& bytes) {
        std::vector<std::uint8_t> types;
        for (const std::uint8_t byte : bytes) {
            Bytes answer(HAPTABLE_FRAME_BODY_PAIR_BYTES);
            answer.resize(haptable_frame_body_pair_take(scene.pair, &body, &line, byte, answer.data()));
            for (const std::uint8_t answered : answer) {
                haptable_frame whole{};
                if (haptable_frame_read(&reader, answered, &whole) == 0) continue;
                types.push_back(whole.type);
                haptable_body_state pose{};
                if (haptable_frame_take_pose(&whole, &pose) == 0) continue;
                EXPECT_EQ(std::memcmp(pose.position_m, session.body().state()->position_m, 12), 0) << whole.sequence;
                EXPECT_EQ(std::memcmp(pose.turn, session.body().state()->turn, 16), 0) << whole.sequence;
            }
        }
        return types;
    };
    const auto state = [](int finger, int of_both, std::uint32_t sequence, const haptable_frame_state& of) {
        Bytes bytes(HAPTABLE_FRAME_BYTES);
        bytes.resize(haptable_frame_write_state_of(finger, of_both, sequence, &of, bytes.data()));
        return bytes;
    };
    for (std::uint32_t tick = 0; tick < 400; ++tick) {
        const float in_m = -0.002F + 1e-5F * static_cast<float>(tick);
        const bool both = tick % 100 > 20;
        FingerInputs in{FingerInput{{in_m, 0.013F, 0.02F}}, {}};
        if (both) in[1] = FingerInput{{0.03F - 0.5F * in_m, 0.016F, 0.02F}};
        session.tick(in, 1000 * tick);
        Bytes bytes;
        for (std::size_t finger = 0; finger < (both ? 2U : 1U); ++finger) {
            haptable_frame_state of{1000 * tick, {}, 0};
            std::copy(in[finger]->at_m.begin(), in[finger]->at_m.end(), of.position_m);
            const Bytes frame = state(static_cast<int>(finger), both ? 1 : 0, tick + 1, of);
            bytes.insert(bytes.end(), frame.begin(), frame.end());
        }
        const std::vector<std::uint8_t> want =
            both ? std::vector<std::uint8_t>{8, 2, 4} : std::vector<std::uint8_t>{8, 2};
        ASSERT_EQ(put(bytes), want) << tick;
        EXPECT_EQ(put(bytes), want) << "again: answered, and not stepped";
        for (std::size_t finger = 0; finger < (both ? 2U : 1U); ++finger)
            ASSERT_EQ(std::memcmp(line.fingers.out[finger].force_n, session.output(finger).force_n, 12), 0) << tick;
    }
    EXPECT_GT(session.output(0).force_n[0] * session.output(0).force_n[0], 0.0F) << "it is pushed";
    Bytes ask(HAPTABLE_FRAME_BYTES);
    ask.resize(haptable_frame_write_ask(11, ask.data()));
    EXPECT_EQ(put(ask), (std::vector<std::uint8_t>{4})) << "a question is no tick";
}

}  // namespace
}  // namespace haptable::test
