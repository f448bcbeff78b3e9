// SPDX-License-Identifier: GPL-2.0-or-later
// The serial line: whole frames come through and garbage does not; the servo's end answers a tick once, of every scene.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "tests/loop/every_scene.hpp"
#include "tests/loop/line_bytes.hpp"

namespace haptable::test {
namespace {

template <std::size_t n>
bool same_floats(const float (&a)[n], const float (&b)[n]) {
    return std::memcmp(a, b, sizeof a) == 0;
}

// ---- frames --------------------------------------------------------------------------------------------------------

constexpr haptable_line_hello kWhole{HAPTABLE_LINE_VERSION, 2, 3, HAPTABLE_LINE_FREE, 0x0123456789abcdef};

Bytes some_frame(std::uint32_t sequence) {
    haptable_line_state state{sequence * 1000, 0, {}};
    state.in[0] = {{0.001F * static_cast<float>(sequence % 100), 0.02F, -0.03F}, sequence % 8, 1};
    return frame_of({HAPTABLE_LINE_VERSION, 1, 0, 0, 0}, state, sequence);
}

// Byte for byte as documented, with the CRCs that zlib's crc32 gives for these bytes.
TEST(LineFrame, HasTheDocumentedBytes) {
    EXPECT_EQ(frame_of(kWhole, 7), (Bytes{0xA5, 0x5A, 12,   0,    10,   7,    0,    0,    0,    3,    2,    3,   1,
                                          0xEF, 0xCD, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01, 0x7B, 0x07, 0xB3, 0x07}));
    haptable_line_state state{0x01020304, 2, {}};
    state.in[0] = {{1.0F, 0.0F, -2.0F}, HAPTABLE_BUTTON_GRAB, 1};
    state.in[1] = {{0.5F, 0.0F, 0.0F}, HAPTABLE_BUTTON_ACKNOWLEDGE, 1};
    EXPECT_EQ(frame_of(kWhole, state, 7),
              (Bytes{0xA5, 0x5A, 38, 0, 11, 7, 0, 0, 0, 4,    3, 2, 1, 3,    2,    0,    0,
                     0x80, 0x3F, 0,  0, 0,  0, 0, 0, 0, 0xC0, 2, 0, 0, 0,    0,    0,    0x00,
                     0x3F, 0,    0,  0, 0,  0, 0, 0, 0, 4,    0, 0, 0, 0x68, 0x08, 0xA3, 0x26}));
    haptable_line_answer answer{};
    haptable_output& first = answer.out[0];
    float value = 0.0F;
    first.state = HAPTABLE_CONTACT;
    for (int c = 0; c < 3; ++c) first.vertex[c] = static_cast<std::uint16_t>(0x1201 + c);
    for (float* const three : {first.force_n, first.god_object_m, first.alpha, first.nodal_force_n[0],
                               first.nodal_force_n[1], first.nodal_force_n[2]})
        for (int a = 0; a < 3; ++a) three[a] = ++value;
    value = 0.0F;
    haptable_body_pose& pose = answer.pose;
    for (const auto& [floats, count] : {std::pair{pose.position_m, 3}, std::pair{pose.turn, 4},
                                        std::pair{pose.velocity_m_per_s, 3}, std::pair{pose.spin_rad_per_s, 3}})
        for (int a = 0; a < count; ++a) floats[a] = value -= 0.5F;
    pose.on_floor = 5;
    answer.q[0] = 0.25F;
    answer.q[1] = -0.25F;
    const Bytes bytes = frame_of({HAPTABLE_LINE_VERSION, 1, 2, HAPTABLE_LINE_FREE, 0}, answer, 7);
    ASSERT_EQ(bytes.size(), 154U);
    EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 13), (Bytes{0xA5, 0x5A, 141, 0, 12, 7, 0, 0, 0, 2, 0, 1, 0x12}));
    EXPECT_EQ(Bytes(bytes.end() - 4, bytes.end()), (Bytes{0x5E, 0x89, 0x95, 0xBA})) << "of all between";
}

// A frame gives back all that its scene holds, and nothing that the scene does not hold.
TEST(LineFrame, ComesOutAsItWentIn) {
    std::mt19937 random(1);
    const auto fill = [&random](float* values, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(random()) * 1e-9F;
    };
    for (const Parts& parts : every_combination()) {
        SCOPED_TRACE(parts.name());
        const haptable_line_hello hello{HAPTABLE_LINE_VERSION, static_cast<std::uint8_t>(parts.fingers),
                                        static_cast<std::uint8_t>(parts.rings ? 16 : 0),
                                        static_cast<std::uint8_t>(parts.is_free ? HAPTABLE_LINE_FREE : 0), 99};
        haptable_line_state state{0x89ABCDEF, 1, {}}, got_state{};
        haptable_line_answer answer{}, got{};
        const haptable_line_answer none{};
        for (int f = 0; f < 2; ++f) {
            fill(state.in[f].finger_m, 3);
            state.in[f].buttons = static_cast<std::uint32_t>(random());
            state.in[f].is_there = static_cast<std::uint8_t>(f);
            haptable_output& out = answer.out[f];
            out.state = static_cast<std::uint8_t>(random() % 6);
            out.faults = static_cast<std::uint8_t>(random() % 8);
            for (std::uint16_t& vertex : out.vertex) vertex = random() & 0xFFFF;
            fill(out.alpha, 3), fill(out.god_object_m, 3), fill(out.force_n, 3), fill(out.nodal_force_n[0], 9);
        }
        fill(answer.pose.position_m, 13);
        answer.pose.on_floor = 0xA5;
        fill(answer.q, HAPTABLE_MODES);
        auto frames = LineEar().hear(frame_of(hello, state, 3) + frame_of(hello, answer, 4));
        ASSERT_EQ(frames.size(), 2U);
        EXPECT_EQ(frames[0].payload.size(), std::size_t(HAPTABLE_LINE_STATE_PAYLOAD(parts.fingers)));
        EXPECT_EQ(frames[1].payload.size(),
                  std::size_t(HAPTABLE_LINE_ANSWER_PAYLOAD(parts.fingers, parts.is_free, hello.modes)));
        ASSERT_EQ(haptable_line_take_state(&frames[0].frame, &hello, &got_state), 1);
        ASSERT_EQ(haptable_line_take_answer(&frames[1].frame, &hello, &got), 1);
        EXPECT_EQ(haptable_line_take_answer(&frames[0].frame, &hello, &got), 0) << "of another type";
        // Written again they have the documented bytes, of which they lack none.
        EXPECT_EQ(frame_of(hello, got_state, 3), frame_of(hello, state, 3));
        EXPECT_EQ(frame_of(hello, got, 4), frame_of(hello, answer, 4));
        for (int f = 0; f < parts.fingers; ++f) EXPECT_EQ(got.out[f].patch, HAPTABLE_NONE);
        if (!parts.is_free) {
            EXPECT_TRUE(same_floats(got.pose.turn, none.pose.turn) && got.pose.on_floor == 0);
        }
        if (!parts.rings) {
            EXPECT_TRUE(same_floats(got.q, none.q));
        }
        // One byte less or more is no frame of this scene.
        for (auto& of : frames)
            for (const int more : {-1, 1}) {
                haptable_line_frame other = of.frame;
                of.payload.resize(of.payload.size() + 1);
                other.payload = of.payload.data();
                other.length = static_cast<std::uint16_t>(other.length + more);
                EXPECT_EQ(haptable_line_take_state(&other, &hello, &got_state), 0);
                EXPECT_EQ(haptable_line_take_answer(&other, &hello, &got), 0);
            }
    }
}

TEST(LineFrame, AHelloOfAnotherVersionIsItsVersionAlone) {
    haptable_line_hello got{};
    for (const int length : {1, 11, 12, 30}) {
        Bytes payload(static_cast<std::size_t>(length), 9);
        const haptable_line_frame other{HAPTABLE_LINE_HELLO, static_cast<std::uint16_t>(length), 1, payload.data()};
        ASSERT_EQ(haptable_line_take_hello(&other, &got), 1);
        EXPECT_TRUE(got.version == 9 && got.fingers == 0 && got.modes == 0 && got.flags == 0 && got.hash == 0);
        payload[0] = HAPTABLE_LINE_VERSION;
        EXPECT_EQ(haptable_line_take_hello(&other, &got), length == 12 ? 1 : 0);
    }
    const haptable_line_frame none{HAPTABLE_LINE_HELLO, 0, 1, nullptr};
    EXPECT_EQ(haptable_line_take_hello(&none, &got), 0);
}

// ---- reading -------------------------------------------------------------------------------------------------------

// A million bytes of garbage, rich in false begins, between frames: no frame that was not sent, none lost that was
// whole.
TEST(LineReader, ResynchronisesAfterAMillionBytesOfGarbage) {
    std::mt19937 random(1);
    LineEar ear(HAPTABLE_LINE_ANSWER_BYTES);
    std::size_t garbage = 0;
    std::uint32_t sequence = 0, found = 0;
    while (garbage < 1'000'000) {
        Bytes bytes(random() % 200);
        for (std::uint8_t& byte : bytes)
            byte = random() % 4 == 0   ? (random() % 2 != 0 ? 0xA5 : 0x5A)
                   : random() % 4 == 0 ? random() & 1
                                       : random() & 0xFF;
        garbage += bytes.size();
        // As many frames as a false begin can cover, and one more.
        for (std::size_t i = 0; i <= HAPTABLE_LINE_ANSWER_BYTES / some_frame(0).size() + 1; ++i)
            bytes = bytes + some_frame(++sequence);
        for (const Heard& got : ear.hear(bytes)) {
            ASSERT_EQ(got.frame.sequence, found + 1);
            found = got.frame.sequence;
            const Bytes sent = some_frame(found);
            ASSERT_EQ(got.payload, Bytes(sent.begin() + 9, sent.end() - 4));
        }
        ASSERT_EQ(found, sequence);
    }
    EXPECT_EQ(ear.reader().frames, sequence);
    EXPECT_EQ(ear.reader().skipped_bytes, garbage);
}

// ---- the servo's end -----------------------------------------------------------------------------------------------

/// A scene behind a line, and the same beside it.
class Servo {
public:
    explicit Servo(const Parts& parts)
        : of_(every_scene().scene(parts)), beside(state_of(of_)), behind_(state_of(of_)) {
        haptable_scene_make(of_.model, of_.pair, of_.body, of_.modes, &scene);
        haptable_line_describe(&scene, &hello);
        beside.check(HAPTABLE_CHECK_ALL);
        behind_.check(HAPTABLE_CHECK_ALL);
        std::uint32_t count = 0;
        const std::uint8_t* bytes = haptable_line_begin(&scene, &line, &count);
        begun = Bytes(bytes, bytes + count);
    }

    Bytes put(const Bytes& bytes) {
        Bytes all;
        for (const std::uint8_t byte : bytes) {
            std::uint32_t count = 0;
            const std::uint8_t* said = haptable_line(&scene, &behind_.servo(0), &line, byte, &count);
            EXPECT_EQ(said == nullptr, count == 0);
            all.insert(all.end(), said, said + count);
        }
        return all;
    }
    Bytes put(std::uint32_t sequence, const haptable_line_state& state) {
        return put(frame_of(hello, state, sequence));
    }
    /// The tick beside the line: what is to be answered.
    Bytes want(std::uint32_t sequence, const haptable_line_state& state) {
        haptable_line_answer answer{};
        for (int f = 0; f < hello.fingers; ++f)
            if ((state.begins >> f & 1) != 0)
                haptable_servo_watch(&beside.servo(f), beside.servo(f).position_us + HAPTABLE_SILENCE_US,
                                     &answer.out[f]);
        if (scene.body != nullptr) haptable_pose_of(&beside.scene(), beside.memory(), &answer.pose);
        beside.step(state.in, state.time_us, answer.out);
        if (scene.modes != nullptr) std::copy_n(beside.modes()->q, scene.modes->count, answer.q);
        last = answer;
        return frame_of(hello, answer, sequence);
    }
    std::uint32_t ticks(int finger = 0) { return behind_.servo(finger).counters.ticks; }

    /// Two sides of the top, deeper with every tick, down to 2 mm; once more from outside, after both were away.
    haptable_line_state state(std::uint32_t tick, unsigned there = 3) const {
        haptable_line_state state{tick * 1000, 0, {}};
        constexpr std::uint32_t kAgain = 115;
        const float z_m = 0.0305F - std::min(2.5e-3F, 1e-4F * static_cast<float>(tick < kAgain ? tick : tick - kAgain));
        for (int f = 0; f < hello.fingers; ++f)
            state.in[f] = {{f == 0 ? 0.0102F : 0.0197F, 0.0143F, z_m}, 0, static_cast<std::uint8_t>(there >> f & 1)};
        return state;
    }

private:
    ServoScene of_;

public:
    haptable_scene scene{};
    haptable_line_hello hello{};
    haptable_line_end line{};
    Bytes begun;  ///< what it has said by itself
    SceneState beside;
    haptable_line_answer last{};

private:
    SceneState behind_;
};

class LineOfEveryScene : public testing::TestWithParam<Parts> {};

INSTANTIATE_TEST_SUITE_P(Scenes, LineOfEveryScene, testing::ValuesIn(every_combination()),
                         [](const auto& of) { return of.param.name(); });

// Alone and together, gone and back, beginning anew, after a gap; each twice: answered twice and stepped once.
TEST_P(LineOfEveryScene, ATickHasTheForcesOfTheScenesStepAndIsSteppedOnce) {
    Servo servo(GetParam());
    std::uint32_t touched = 0, later = 0;
    for (std::uint32_t tick = 0; tick < 200; ++tick) {
        unsigned there = 3;
        if (tick > 60 && tick < 80) there = 1;
        if (tick > 100 && tick < 110) there = 2;
        haptable_line_state state = servo.state(tick, there);
        if (tick == 150) state.begins = 2;
        if (tick == 160) state.begins = 1;
        if (tick == 170) later = 20;
        state.time_us += 1000 * later;
        const Bytes want = servo.want(tick + 1, state);
        ASSERT_EQ(servo.put(tick + 1, state), want) << tick;
        ASSERT_EQ(servo.put(tick + 1, state), want) << tick;
        for (int f = 0; f < servo.hello.fingers; ++f) {
            touched += static_cast<std::uint32_t>(haptable_touches(servo.last.out[f].state));
            if ((there >> f & 1) == 0) {
                EXPECT_EQ(servo.last.out[f].state, HAPTABLE_SILENT);
            }
        }
        // Where nobody saw it come it feels nothing; a body that moves may meet it again.
        if (!GetParam().is_free && !GetParam().rings) {
            if (tick == 150 && servo.hello.fingers == 2) {
                EXPECT_EQ(servo.last.out[0].state, HAPTABLE_CONTACT);
                EXPECT_EQ(servo.last.out[1].state, HAPTABLE_FREE);
            }
            if (tick == 159) {
                EXPECT_EQ(servo.last.out[0].state, HAPTABLE_CONTACT);
            }
            if (tick == 160 || tick == 170) {
                EXPECT_EQ(servo.last.out[0].state, HAPTABLE_FREE);
            }
        }
    }
    EXPECT_GT(touched, 40U);
    EXPECT_EQ(servo.ticks(), servo.beside.servo(0).counters.ticks);
}

TEST_P(LineOfEveryScene, AHelloSaysWhatTheSceneIsAndIsAskedForByItsVersion) {
    Servo servo(GetParam());
    EXPECT_EQ(servo.begun, frame_of(servo.hello)) << "by itself, when it begins";
    EXPECT_EQ(servo.hello.version, HAPTABLE_LINE_VERSION);
    EXPECT_EQ(servo.hello.fingers, GetParam().fingers);
    EXPECT_EQ(servo.hello.modes, GetParam().rings ? 2 : 0);
    EXPECT_EQ(servo.hello.flags, GetParam().is_free ? HAPTABLE_LINE_FREE : 0);
    EXPECT_EQ(servo.hello.hash, servo.scene.model->hash);
    // It is no tick, and the last tick's answer stays.
    const Bytes want = servo.want(1, servo.state(0));
    EXPECT_EQ(servo.put(1, servo.state(0)), want);
    EXPECT_EQ(servo.put(frame_of(servo.hello, 5)), frame_of(servo.hello, 5));
    EXPECT_EQ(servo.put(1, servo.state(0)), want);
    EXPECT_EQ(servo.ticks(), 1U);
    // A host of another version may mean something else by the same bytes: it hears so, and gets no tick.
    haptable_line_hello other = servo.hello, said = servo.hello;
    ++other.version;
    said.flags |= HAPTABLE_LINE_OTHER_VERSION;
    EXPECT_EQ(servo.put(frame_of(other, 6)), frame_of(said, 6));
    EXPECT_TRUE(servo.put(2, servo.state(1)).empty());
    EXPECT_EQ(servo.ticks(), 1U);
    EXPECT_EQ(servo.put(frame_of(servo.hello, 7)), frame_of(servo.hello, 7));
    EXPECT_EQ(servo.put(2, servo.state(1)), servo.want(2, servo.state(1)));
}

// Bits fall over both ways, noise comes between, answers are lost: a host that asks until it is answered gets the
// forces of the scene's step, each tick stepped once.
TEST_P(LineOfEveryScene, ADamagedLineChangesNoForce) {
    Servo servo(GetParam());
    LineEar host(HAPTABLE_LINE_ANSWER_BYTES);
    std::mt19937 random(2);
    const auto damaged = [&random](Bytes bytes) {
        if (random() % 3 == 0) bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
        Bytes noise(random() % 3 == 0 ? random() % 60 : 0);
        for (std::uint8_t& byte : noise) byte = random() % 4 == 0 ? 0xA5 : random() & 0xFF;
        return noise + bytes;
    };
    int asked = 0;
    for (std::uint32_t tick = 0; tick < 150; ++tick) {
        const haptable_line_state state = servo.state(tick, tick % 50 < 10 ? 1 : 3);
        const Bytes want = servo.want(tick + 1, state);
        bool is_answered = false;
        for (int tries = 0; tries < 100 && !is_answered; ++tries, ++asked) {
            const Bytes answer = servo.put(damaged(frame_of(servo.hello, state, tick + 1)));
            if (answer.empty() || random() % 5 == 0) continue;
            for (const Heard& got : host.hear(damaged(answer))) {
                ASSERT_EQ(got.payload, Bytes(want.begin() + 9, want.end() - 4)) << tick;
                is_answered = true;
            }
        }
        ASSERT_TRUE(is_answered) << tick;
    }
    EXPECT_GT(asked, 200);
    for (int f = 0; f < servo.hello.fingers; ++f) EXPECT_EQ(servo.ticks(f), servo.beside.servo(f).counters.ticks);
}

}  // namespace
}  // namespace haptable::test
