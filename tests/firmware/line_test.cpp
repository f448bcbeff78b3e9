// SPDX-License-Identifier: GPL-2.0-or-later
// The serial line: whole frames come through and garbage does not; the servo's end answers a tick once, of every scene.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/loop/every_scene.hpp"
#include "tests/loop/line_end.hpp"

namespace haptable::test {
namespace {

// ---- frames --------------------------------------------------------------------------------------------------------

constexpr haptable_line_hello kWhole{HAPTABLE_LINE_VERSION, 2, 3, HAPTABLE_LINE_FREE, 0x0123456789abcdef};
constexpr haptable_line_hello kTool{HAPTABLE_LINE_VERSION, 1, 0, HAPTABLE_LINE_TOOL, 5};

haptable_line_hello hello_of_hands(int hands) {
    return {HAPTABLE_LINE_VERSION, static_cast<std::uint8_t>(hands), 0, 0, 5};
}

Bytes some_frame(std::uint32_t sequence) {
    TargetState state{sequence * 1000};
    state.in[0] = {{0.001F * static_cast<float>(sequence % 100), 0.02F, -0.03F}, sequence % 8, 1};
    return frame_of(hello_of_hands(1), state, sequence);
}

// Byte for byte as documented, with the CRCs that zlib's crc32 gives for these bytes.
TEST(LineFrame, HasTheDocumentedBytes) {
    EXPECT_EQ(frame_of(kWhole, 7), (Bytes{0xA5, 0x5A, 12,   0,    10,   7,    0,    0,    0,    3,    2,    3,   1,
                                          0xEF, 0xCD, 0xAB, 0x89, 0x67, 0x45, 0x23, 0x01, 0x7B, 0x07, 0xB3, 0x07}));
    TargetState state{0x01020304, 2};
    state.in[0] = {{1.0F, 0.0F, -2.0F}, HAPTABLE_BUTTON_GRAB, 1};
    state.in[1] = {{0.5F, 0.0F, 0.0F}, HAPTABLE_BUTTON_ACKNOWLEDGE, 1};
    EXPECT_EQ(frame_of(kWhole, state, 7),
              (Bytes{0xA5, 0x5A, 38, 0, 11, 7, 0, 0, 0, 4,    3, 2, 1, 3,    2,    0,    0,
                     0x80, 0x3F, 0,  0, 0,  0, 0, 0, 0, 0xC0, 2, 0, 0, 0,    0,    0,    0x00,
                     0x3F, 0,    0,  0, 0,  0, 0, 0, 0, 4,    0, 0, 0, 0x68, 0x08, 0xA3, 0x26}));
    TargetAnswer answer;
    haptable_output& first = answer.output[0];
    float value = 0.0F;
    first.state = HAPTABLE_CONTACT;
    for (int c = 0; c < 3; ++c) first.vertex[c] = static_cast<std::uint16_t>(0x1201 + c);
    for (float* const three : {first.force_n, first.god_object_m, first.alpha, first.nodal_force_n[0],
                               first.nodal_force_n[1], first.nodal_force_n[2]})
        for (int a = 0; a < 3; ++a) three[a] = ++value;
    value = 0.0F;
    haptable_body_state& body = answer.body;
    for (const auto& [floats, count] : {std::pair{body.position_m, 3}, std::pair{body.turn, 4},
                                        std::pair{body.velocity_m_per_s, 3}, std::pair{body.spin_rad_per_s, 3}})
        for (int a = 0; a < count; ++a) floats[a] = value -= 0.5F;
    body.on_floor = 5;
    answer.modes.q[0] = 0.25F;
    answer.modes.q[1] = -0.25F;
    const Bytes bytes = frame_of({HAPTABLE_LINE_VERSION, 1, 2, HAPTABLE_LINE_FREE, 0}, answer, 7);
    ASSERT_EQ(bytes.size(), 154U);
    EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 13), (Bytes{0xA5, 0x5A, 141, 0, 12, 7, 0, 0, 0, 2, 0, 1, 0x12}));
    EXPECT_EQ(Bytes(bytes.end() - 4, bytes.end()), (Bytes{0x5E, 0x89, 0x95, 0xBA})) << "of all between";
}

TEST(LineFrame, OfAToolHasTheDocumentedBytes) {
    TargetState state{0x01020304, 1, {}, {1.0F, 0.0F, 0.5F, -2.0F}};
    state.in[0] = {{1.0F, 0.0F, -2.0F}, HAPTABLE_BUTTON_ACKNOWLEDGE, 1};
    EXPECT_EQ(frame_of(kTool, state, 7),
              (Bytes{0xA5, 0x5A, 38, 0, 13, 7, 0, 0, 0,    4,    3, 2, 1,    1,    1,    0,    0,
                     0x80, 0x3F, 0,  0, 0,  0, 0, 0, 0,    0xC0, 4, 0, 0,    0,    0,    0,    0x80,
                     0x3F, 0,    0,  0, 0,  0, 0, 0, 0x3F, 0,    0, 0, 0xC0, 0xCD, 0x23, 0x8E, 0x4D}));
    TargetAnswer answer;
    haptable_tool_line_answer& tool = answer.tool;
    float value = 0.0F;
    answer.output[0].state = HAPTABLE_CONTACT;
    tool.inside = 0x80000002;
    for (float* of : {tool.out.torque_n_m, tool.out.position_m, tool.out.turn})
        for (int a = 0; a < (of == tool.out.turn ? 4 : 3); ++a) of[a] = value += 0.25F;
    tool.stored_j = 3.0F;
    for (const int i : {1, 31}) {
        tool.point[i].patch = static_cast<std::uint16_t>(0x1200 + i);
        for (float* of : {tool.point[i].alpha, tool.point[i].god_object_m, tool.point[i].load_n})
            for (int a = 0; a < 3; ++a) of[a] = value += 0.25F;
    }
    const Bytes bytes = frame_of(kTool, answer, 7);
    ASSERT_EQ(bytes.size(), 13U + 128U + 2U * 38U);
    EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 11), (Bytes{0xA5, 0x5A, 204, 0, 14, 7, 0, 0, 0, 2, 0}));
    const auto number = [&bytes](std::size_t at) {
        float of = 0.0F;
        std::memcpy(&of, &bytes[9 + at], 4);
        return of;
    };
    for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(number(80 + 4 * i), 0.25F * float(i + 1)) << "torque, pose";
    EXPECT_EQ(number(120), 3.0F);
    EXPECT_EQ(Bytes(bytes.begin() + 9 + 124, bytes.begin() + 9 + 130), (Bytes{2, 0, 0, 0x80, 0x01, 0x12}));
    for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(number(130 + 4 * i), 0.25F * float(i + 11)) << "point 1";
    EXPECT_EQ(bytes[9 + 166], 0x1F);
    for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(number(168 + 4 * i), 0.25F * float(i + 20)) << "point 31";
}

/// Where a body is, its modes, a tool's points, hands: random numbers of any scene.
class RandomAnswer {
public:
    TargetAnswer operator()() {
        TargetAnswer answer;
        for (haptable_output& out : answer.output) fill(out);
        for (float* three : {answer.body.position_m, answer.body.velocity_m_per_s, answer.body.spin_rad_per_s,
                             answer.tool.out.torque_n_m, answer.tool.out.position_m})
            fill(three, 3);
        for (float* turn : {answer.body.turn, answer.tool.out.turn}) fill(turn, 4);
        answer.body.on_floor = 0xA5;
        fill(answer.modes.q, HAPTABLE_MODES);
        fill(&answer.tool.stored_j, 1);
        answer.tool.inside = static_cast<std::uint32_t>(random_());
        for (haptable_line_point& point : answer.tool.point) {
            point.patch = static_cast<std::uint16_t>(random_() & 0xFFFF);
            fill(point.alpha, 3), fill(point.god_object_m, 3), fill(point.load_n, 3);
        }
        return answer;
    }

private:
    void fill(float* values, int count) {
        for (int i = 0; i < count; ++i) values[i] = static_cast<float>(random_()) * 1e-9F;
    }
    void fill(haptable_output& out) {
        out.state = static_cast<std::uint8_t>(random_() % 6);
        out.faults = static_cast<std::uint8_t>(random_() % 8);
        for (std::uint16_t& vertex : out.vertex) vertex = static_cast<std::uint16_t>(random_() & 0xFFFF);
        fill(out.alpha, 3), fill(out.god_object_m, 3), fill(out.force_n, 3), fill(out.nodal_force_n[0], 9);
    }
    std::mt19937 random_{1};
};

bool take_state(const haptable_line_frame& frame, const haptable_line_hello& hello, TargetState& state) {
    haptable_line_state fingers{};
    haptable_hands_line_state hands{};
    haptable_tool_line_state tool{};
    const auto give = [&state](const auto& got, const haptable_input* in, int count) {
        state.time_us = got.time_us;
        state.begins = got.begins;
        std::copy_n(in, count, state.in.begin());
        return true;
    };
    if ((hello.flags & HAPTABLE_LINE_TOOL) != 0) {
        if (haptable_tool_line_take_state(&frame, &tool) == 0) return false;
        std::copy_n(tool.in.turn, 4, state.turn.begin());
        return give(tool, &tool.in.hand, 1);
    }
    if (hello.fingers > HAPTABLE_FINGERS)
        return haptable_hands_line_take_state(&frame, &hello, &hands) != 0 && give(hands, hands.in, HAPTABLE_HANDS);
    return haptable_line_take_state(&frame, &hello, &fingers) != 0 && give(fingers, fingers.in, HAPTABLE_FINGERS);
}

// A frame gives back all that its scene holds, and nothing that the scene does not hold; one byte less or more, or
// another type, is no frame of the kind.
TEST(LineFrame, ComesOutAsItWentIn) {
    RandomAnswer random;
    const PathOfHands path(3);
    std::vector<Parts> all = every_combination();
    for (const int hands : {4, 6, 7}) all.push_back({hands});
    for (const Parts& parts : all)
        for (std::uint32_t trial = 0; trial < 100; ++trial) {
            SCOPED_TRACE(parts.name());
            const haptable_line_hello hello{HAPTABLE_LINE_VERSION, static_cast<std::uint8_t>(parts.fingers),
                                            static_cast<std::uint8_t>(parts.rings ? 16 : 0),
                                            static_cast<std::uint8_t>((parts.is_free ? HAPTABLE_LINE_FREE : 0) |
                                                                      (parts.has_tool ? HAPTABLE_LINE_TOOL : 0)),
                                            99};
            TargetState state = path.at(trial), got_state;
            state.begins = static_cast<std::uint8_t>(trial);
            state.in[0].buttons = 0x89ABCDEF + trial;
            state.in[trial % 8].is_there = 0;
            const TargetAnswer answer = random();
            TargetAnswer got;
            const Bytes sent = frame_of(hello, state, 3), said = frame_of(hello, answer, 4);
            auto frames = LineEar().hear(sent + said);
            ASSERT_EQ(frames.size(), 2U);
            if (!parts.has_tool) {
                EXPECT_EQ(frames[0].frame.length, HAPTABLE_LINE_STATE_PAYLOAD(parts.fingers));
                EXPECT_EQ(frames[1].frame.length,
                          HAPTABLE_LINE_ANSWER_PAYLOAD(parts.fingers, parts.is_free, hello.modes));
            }
            ASSERT_TRUE(take_state(frames[0].frame, hello, got_state));
            ASSERT_TRUE(take_answer(frames[1].frame, hello, got));
            EXPECT_EQ(got.sequence, 4U);
            for (int f = 0; f < parts.fingers; ++f) EXPECT_EQ(got.output[std::size_t(f)].patch, HAPTABLE_NONE);
            EXPECT_TRUE(parts.is_free || (got.body.turn[0] == 0.0F && got.body.on_floor == 0));
            EXPECT_TRUE(parts.rings || got.modes.q[0] == 0.0F);
            // Written again they are the same bytes.
            EXPECT_EQ(frame_of(hello, got_state, 3), sent);
            EXPECT_EQ(frame_of(hello, got, 4), said);
            EXPECT_FALSE(take_state(frames[1].frame, hello, got_state)) << "an answer";
            EXPECT_FALSE(take_answer(frames[0].frame, hello, got)) << "a state";
            for (Heard& of : frames)
                for (const int more : {-1, 1, -38, 38}) {
                    haptable_line_frame other = of.frame;
                    of.payload.resize(of.frame.length + 38U);
                    other.payload = of.payload.data();
                    other.length = static_cast<std::uint16_t>(other.length + more);
                    EXPECT_FALSE(take_state(other, hello, got_state)) << more;
                    EXPECT_FALSE(take_answer(other, hello, got)) << more;
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
class LineOfEveryScene : public testing::TestWithParam<Parts> {
protected:
    LineOfEveryScene() { beside.check(HAPTABLE_CHECK_ALL); }
    Bytes put(std::uint32_t number, const TargetState& state) { return end.put(frame_of(end.hello, state, number)); }
    /// The tick beside the line: what is to be answered.
    Bytes want(std::uint32_t number, const TargetState& state) {
        answer = {};
        for (std::size_t f = 0; f < fingers; ++f) {
            if ((state.begins >> f & 1U) == 0) continue;
            const std::uint32_t silent_us = beside.servo(f).position_us + HAPTABLE_SILENCE_US;
            if (GetParam().has_tool) beside.release(silent_us, answer.tool.out);
            if (!GetParam().has_tool) haptable_servo_watch(&beside.servo(f), silent_us, &answer.output[f]);
        }
        if (GetParam().has_tool) {
            haptable_tool_input in{state.in[0], {}};
            std::copy_n(state.turn.begin(), 4, in.turn);
            beside.step(in, state.time_us, answer.tool.out);
            answer.output[0] = answer.tool.out.hand;
            answer.tool.stored_j = static_cast<float>(beside.tool_energy_j());
            for (std::size_t i = 0; i < beside.scene_points()->count; ++i) put_point(i, answer.tool);
        } else {
            beside.step(state.in.data(), state.time_us, answer.output.data());
        }
        if (beside.touched() != nullptr) answer.body = *beside.touched();
        if (beside.modes() != nullptr) answer.modes = *beside.modes();
        return frame_of(end.hello, answer, number);
    }
    void put_point(std::size_t i, haptable_tool_line_answer& tool) {
        const haptable_point& from = beside.point_state(i);
        if (from.is_inside == 0) return;
        tool.inside |= 1U << i;
        tool.point[i].patch = from.at.patch;
        std::copy_n(from.at.alpha, 3, tool.point[i].alpha);
        std::copy_n(from.at.god_object_m, 3, tool.point[i].god_object_m);
        std::copy_n(from.load_n, 3, tool.point[i].load_n);
    }
    std::uint32_t ticks(std::size_t finger = 0) const { return end.state.servo(finger).counters.ticks; }

    const ServoScene scene = every_scene().scene(GetParam());
    const std::size_t fingers = static_cast<std::size_t>(GetParam().fingers);
    LineEnd end{scene};
    SceneState beside = state_of(scene);
    TargetAnswer answer;  ///< wanted last
};

INSTANTIATE_TEST_SUITE_P(Scenes, LineOfEveryScene, testing::ValuesIn(every_combination()),
                         [](const auto& of) { return of.param.name(); });

// Turning, together and alone, gone and back, beginning anew, after a gap; each twice: answered twice, stepped once.
TEST_P(LineOfEveryScene, ATickHasTheBitsOfTheServoBesideItAndIsSteppedOnce) {
    const PathOfHands path(5);
    std::size_t touched = 0, turned = 0;
    std::uint32_t later = 0;
    for (std::uint32_t tick = 0; tick < 1200; ++tick) {
        TargetState state = path.at(tick);
        if (tick / 40 % 3 == 1) state.in[tick / 40 % 8].is_there = 0;
        if (tick % 150 == 149) state.begins = static_cast<std::uint8_t>(tick / 150 + 1);
        const bool after_a_gap = tick % 400 == 399;
        if (after_a_gap) later += HAPTABLE_SILENCE_US;
        state.time_us += later;
        const Bytes wanted = want(tick + 1, state);
        ASSERT_EQ(put(tick + 1, state), wanted) << tick;
        ASSERT_EQ(put(tick + 1, state), wanted) << tick;
        for (std::size_t f = 0; f < fingers; ++f) {
            const std::uint8_t is = answer.output[f].state;
            touched += static_cast<std::size_t>(haptable_touches(is));
            if (state.in[f].is_there == 0) {
                EXPECT_EQ(is, HAPTABLE_SILENT) << tick;
            } else if (after_a_gap || (state.begins >> f & 1U) != 0) {
                // Where nobody saw it come it feels nothing; a body that moves may meet it again.
                EXPECT_TRUE(is == HAPTABLE_FREE || GetParam().is_free || GetParam().rings) << tick;
            }
        }
        turned += std::abs(answer.tool.out.torque_n_m[0]) > 1e-5F;
    }
    EXPECT_GT(touched, (GetParam().is_free ? 250 : 300) * fingers) << "one that is free is pushed away";
    EXPECT_EQ(turned > 300, GetParam().has_tool);
    for (std::size_t f = 0; f < fingers; ++f) EXPECT_EQ(ticks(f), beside.servo(f).counters.ticks);
}

TEST_P(LineOfEveryScene, AHelloSaysWhatTheSceneIsAndIsAskedForByItsVersion) {
    const PathOfHands path(1);
    EXPECT_EQ(end.begun, frame_of(end.hello)) << "by itself, when it begins";
    EXPECT_EQ(end.hello.version, HAPTABLE_LINE_VERSION);
    EXPECT_EQ(end.hello.fingers, fingers);
    EXPECT_EQ(end.hello.modes, GetParam().rings ? 2 : 0);
    EXPECT_EQ(end.hello.flags,
              (GetParam().is_free ? HAPTABLE_LINE_FREE : 0) | (GetParam().has_tool ? HAPTABLE_LINE_TOOL : 0));
    EXPECT_EQ(end.hello.hash, scene.model->hash);
    // It is no tick, and the last tick's answer stays.
    const Bytes wanted = want(1, path.at(0));
    EXPECT_EQ(put(1, path.at(0)), wanted);
    EXPECT_EQ(end.put(frame_of(end.hello, 5)), frame_of(end.hello, 5));
    EXPECT_EQ(put(1, path.at(0)), wanted);
    EXPECT_EQ(ticks(), 1U);
    // A host of another version may mean something else by the same bytes: it hears so, and gets no tick.
    for (const int newer : {1, -1}) {
        haptable_line_hello other = end.hello, said = end.hello;
        other.version = static_cast<std::uint8_t>(other.version + newer);
        said.flags |= HAPTABLE_LINE_OTHER_VERSION;
        EXPECT_EQ(end.put(frame_of(other, 6)), frame_of(said, 6));
        EXPECT_TRUE(put(2, path.at(1)).empty());
        EXPECT_EQ(ticks(), 1U);
    }
    EXPECT_EQ(end.put(frame_of(end.hello, 7)), frame_of(end.hello, 7));
    EXPECT_EQ(put(2, path.at(1)), want(2, path.at(1)));
}

// States of another kind of scene: not answered, no tick.
TEST_P(LineOfEveryScene, AStateThatDoesNotFitTheSceneIsNone) {
    const TargetState state = PathOfHands(1).at(0);
    for (int hands = 1; hands <= HAPTABLE_HANDS; ++hands) {
        const bool fits = hands == GetParam().fingers && !GetParam().has_tool;
        EXPECT_EQ(end.put(frame_of(hello_of_hands(hands), state, 1)).empty(), !fits) << hands;
    }
    EXPECT_EQ(end.put(frame_of(kTool, state, 1)).empty(), !GetParam().has_tool);
    EXPECT_EQ(ticks(), 1U);
    // What is longer than a state of this scene does not swallow one that comes after it.
    EXPECT_FALSE(end.put(frame_of(hello_of_hands(8), state, 1) + frame_of(end.hello, state, 2)).empty());
}

// Bits fall over both ways, noise comes between, answers are lost: a host that asks until it is answered gets the
// forces of the scene's step, each tick stepped once.
TEST_P(LineOfEveryScene, ADamagedLineChangesNoForce) {
    const PathOfHands path(1);
    LineEar host;
    std::mt19937 random(2);
    const auto damaged = [&random](Bytes bytes) {
        if (random() % 3 == 0) bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
        Bytes noise(random() % 3 == 0 ? random() % 60 : 0);
        for (std::uint8_t& byte : noise) byte = random() % 4 == 0 ? 0xA5 : random() & 0xFF;
        return noise + bytes;
    };
    int asked = 0;
    for (std::uint32_t tick = 0; tick < 150; ++tick) {
        TargetState state = path.at(tick);
        if (tick % 50 < 10) state.in[1].is_there = 0;
        const Bytes wanted = want(tick + 1, state);
        bool is_answered = false;
        for (int tries = 0; tries < 100 && !is_answered; ++tries, ++asked) {
            const Bytes said = end.put(damaged(frame_of(end.hello, state, tick + 1)));
            if (said.empty() || random() % 5 == 0) continue;
            for (const Heard& got : host.hear(damaged(said))) {
                ASSERT_EQ(got.payload, Bytes(wanted.begin() + 9, wanted.end() - 4)) << tick;
                is_answered = true;
            }
        }
        ASSERT_TRUE(is_answered) << tick;
    }
    EXPECT_GT(asked, 200);
    for (std::size_t f = 0; f < fingers; ++f) EXPECT_EQ(ticks(f), beside.servo(f).counters.ticks);
}

}  // namespace
}  // namespace haptable::test
