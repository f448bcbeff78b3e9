// SPDX-License-Identifier: GPL-2.0-or-later
// The serial line of a tool and of three hands and more: the bits of the servo beside it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/loop/points_line.hpp"

namespace haptable::test {
namespace {

haptable_line_hello hello_of_hands(int hands) {
    return {HAPTABLE_LINE_VERSION, static_cast<std::uint8_t>(hands), 0, 0, 5};
}
constexpr haptable_line_hello kToolHello{HAPTABLE_LINE_VERSION, 1, 0, HAPTABLE_LINE_TOOL, 5};

class RandomAnswer {
public:
    PointsAnswer operator()() {
        PointsAnswer answer;
        for (haptable_output& out : answer.hands.out) fill(out);
        fill(answer.tool.out.hand);
        for (float* three : {answer.tool.out.torque_n_m, answer.tool.out.position_m}) fill(three, 3);
        fill(answer.tool.out.turn, 4);
        fill(&answer.tool.stored_j, 1);
        answer.tool.inside = static_cast<std::uint32_t>(random_());
        for (std::uint32_t i = 0; i < HAPTABLE_POINTS; ++i) {
            if ((answer.tool.inside >> i & 1U) == 0) continue;
            haptable_line_point& point = answer.tool.point[i];
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
        out.patch = HAPTABLE_NONE;
        for (std::uint16_t& vertex : out.vertex) vertex = static_cast<std::uint16_t>(random_() & 0xFFFF);
        fill(out.alpha, 3), fill(out.god_object_m, 3), fill(out.force_n, 3), fill(out.nodal_force_n[0], 9);
    }
    std::mt19937 random_{1};
};

// ---- frames --------------------------------------------------------------------------------------------------------

// Byte for byte as documented, with the CRCs that zlib's crc32 gives for these bytes.
TEST(LinePointsFrame, HasTheDocumentedBytes) {
    PointsState state{0x01020304, 1, {}, {1.0F, 0.0F, 0.5F, -2.0F}};
    state.in[0] = {{1.0F, 0.0F, -2.0F}, HAPTABLE_BUTTON_ACKNOWLEDGE, 1};
    EXPECT_EQ(points_state_frame(7, kToolHello, state),
              (Bytes{0xA5, 0x5A, 38, 0, 13, 7, 0, 0, 0,    4,    3, 2, 1,    1,    1,    0,    0,
                     0x80, 0x3F, 0,  0, 0,  0, 0, 0, 0,    0xC0, 4, 0, 0,    0,    0,    0,    0x80,
                     0x3F, 0,    0,  0, 0,  0, 0, 0, 0x3F, 0,    0, 0, 0xC0, 0xCD, 0x23, 0x8E, 0x4D}));
    PointsAnswer answer;
    haptable_tool_line_answer& tool = answer.tool;
    float value = 0.0F;
    tool.out.hand.state = HAPTABLE_CONTACT;
    tool.inside = 0x80000002;
    for (float* of : {tool.out.torque_n_m, tool.out.position_m, tool.out.turn})
        for (int a = 0; a < (of == tool.out.turn ? 4 : 3); ++a) of[a] = value += 0.25F;
    tool.stored_j = 3.0F;
    for (const int i : {1, 31}) {
        tool.point[i].patch = static_cast<std::uint16_t>(0x1200 + i);
        for (float* of : {tool.point[i].alpha, tool.point[i].god_object_m, tool.point[i].load_n})
            for (int a = 0; a < 3; ++a) of[a] = value += 0.25F;
    }
    const Bytes bytes = points_answer_frame(7, kToolHello, answer);
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

// A frame gives back all that was written; one byte less or more, or another type, is no frame of the kind.
TEST(LinePointsFrame, ComesOutAsItWentIn) {
    RandomAnswer random;
    PointsPath path(3);
    for (int trial = 0; trial < 100; ++trial)
        for (const int hands : {0, 3, 4, 5, 6, 7, 8}) {
            SCOPED_TRACE(LinePoints{hands}.name());
            const haptable_line_hello hello = hands == 0 ? kToolHello : hello_of_hands(hands);
            const PointsState state = path.at(static_cast<std::uint32_t>(trial));
            const PointsAnswer answer = random();
            const Bytes sent = points_state_frame(3, hello, state), said = points_answer_frame(4, hello, answer);
            auto frames = LineEar().hear(sent + said);
            ASSERT_EQ(frames.size(), 2U);
            haptable_tool_line_state tool_state{};
            haptable_hands_line_state hands_state{};
            PointsAnswer got;
            const auto take_state = [&](const haptable_line_frame& frame) {
                return hands == 0 ? haptable_tool_line_take_state(&frame, &tool_state)
                                  : haptable_hands_line_take_state(&frame, &hello, &hands_state);
            };
            const auto take_answer = [&](const haptable_line_frame& frame) {
                return hands == 0 ? haptable_tool_line_take_answer(&frame, &got.tool)
                                  : haptable_hands_line_take_answer(&frame, &hello, &got.hands);
            };
            ASSERT_EQ(take_state(frames[0].frame), 1);
            ASSERT_EQ(take_answer(frames[1].frame), 1);
            // Written again they are the same bytes.
            PointsState again{hands == 0 ? tool_state.time_us : hands_state.time_us,
                              hands == 0 ? tool_state.begins : hands_state.begins,
                              {},
                              {}};
            std::copy_n(hands_state.in, HAPTABLE_HANDS, again.in.begin());
            if (hands == 0) again.in[0] = tool_state.in.hand;
            std::copy_n(tool_state.in.turn, 4, again.turn.begin());
            EXPECT_EQ(points_state_frame(3, hello, again), sent);
            EXPECT_EQ(points_answer_frame(4, hello, got), said);
            EXPECT_EQ(take_state(frames[1].frame), 0) << "an answer";
            EXPECT_EQ(take_answer(frames[0].frame), 0) << "a state";
            for (Heard& of : frames)
                for (const int more : {-1, 1, -38, 38}) {
                    haptable_line_frame other = of.frame;
                    of.payload.resize(of.frame.length + 38U);
                    other.payload = of.payload.data();
                    other.length = static_cast<std::uint16_t>(other.length + more);
                    EXPECT_EQ(take_state(other), 0) << more;
                    EXPECT_EQ(take_answer(other), 0) << more;
                }
        }
}

// ---- the servo's end -----------------------------------------------------------------------------------------------

/// The scene behind a line, and the same beside it.
class LineOfPoints : public testing::TestWithParam<LinePoints> {
protected:
    Bytes put(std::uint32_t sequence, const PointsState& state) {
        return end.put(points_state_frame(sequence, end.hello, state));
    }
    /// The tick beside the line: what is to be answered.
    Bytes want(std::uint32_t sequence, const PointsState& state) {
        answer = {};
        if (GetParam().hands == 0) {
            haptable_tool_input in{state.in[0], {}};
            std::copy_n(state.turn.begin(), 4, in.turn);
            if ((state.begins & 1U) != 0)
                beside.release(beside.servo(0).position_us + HAPTABLE_SILENCE_US, answer.tool.out);
            beside.step(in, state.time_us, answer.tool.out);
            answer.tool.stored_j = static_cast<float>(beside.tool_energy_j());
            for (std::size_t i = 0; i < beside.scene_points()->count; ++i) {
                const haptable_point& from = beside.point_state(i);
                if (from.is_inside == 0) continue;
                answer.tool.inside |= 1U << i;
                answer.tool.point[i].patch = from.at.patch;
                std::copy_n(from.at.alpha, 3, answer.tool.point[i].alpha);
                std::copy_n(from.at.god_object_m, 3, answer.tool.point[i].god_object_m);
                std::copy_n(from.load_n, 3, answer.tool.point[i].load_n);
            }
        } else {
            for (std::size_t f = 0; f < beside.fingers(); ++f)
                if ((state.begins >> f & 1U) != 0)
                    haptable_servo_watch(&beside.servo(f), beside.servo(f).position_us + HAPTABLE_SILENCE_US,
                                         &answer.hands.out[f]);
            beside.step(state.in.data(), state.time_us, answer.hands.out);
        }
        return points_answer_frame(sequence, end.hello, answer);
    }
    std::size_t fingers() const { return beside.fingers(); }
    const haptable_output& output(std::size_t finger) const {
        return GetParam().hands == 0 ? answer.tool.out.hand : answer.hands.out[finger];
    }
    std::uint32_t ticks() { return end.state.servo(0).counters.ticks; }

    const ServoScene scene = PointsScene::of(GetParam()).scene();
    PointsEnd end{scene};
    SceneState beside = state_of(scene);
    PointsAnswer answer;  ///< wanted last
    void SetUp() override { beside.check(HAPTABLE_CHECK_ALL); }
};

INSTANTIATE_TEST_SUITE_P(Scenes, LineOfPoints,
                         testing::Values(LinePoints{0}, LinePoints{3}, LinePoints{5}, LinePoints{8}),
                         [](const auto& of) { return of.param.name(); });

// Turning, together and alone, gone and back, beginning anew, after a gap; each twice: answered twice, stepped once.
TEST_P(LineOfPoints, ATickHasTheBitsOfTheServoBesideItAndIsSteppedOnce) {
    PointsPath path(5);
    std::size_t touched = 0, turned = 0;
    std::uint32_t later = 0;
    for (std::uint32_t tick = 0; tick < 1200; ++tick) {
        PointsState state = path.at(tick);
        if (tick / 40 % 3 == 1) state.in[tick / 40 % 8].is_there = 0;
        if (tick % 150 == 149) state.begins = static_cast<std::uint8_t>(tick / 150 + 1);
        if (tick % 400 == 399) later += HAPTABLE_SILENCE_US;
        state.time_us += later;
        const Bytes wanted = want(tick + 1, state);
        ASSERT_EQ(put(tick + 1, state), wanted) << tick;
        ASSERT_EQ(put(tick + 1, state), wanted) << tick;
        for (std::size_t f = 0; f < fingers(); ++f)
            touched += static_cast<std::size_t>(haptable_touches(output(f).state));
        turned += std::abs(answer.tool.out.torque_n_m[0]) > 1e-5F;
    }
    EXPECT_GT(touched, 300 * fingers());
    EXPECT_EQ(turned > 300, GetParam().hands == 0);
    EXPECT_EQ(ticks(), beside.servo(0).counters.ticks);
}

TEST_P(LineOfPoints, AHelloSaysWhatTheSceneIs) {
    EXPECT_EQ(end.begun, frame_of(end.hello));
    EXPECT_EQ(end.hello.version, HAPTABLE_LINE_VERSION);
    EXPECT_EQ(end.hello.fingers, GetParam().hands == 0 ? 1 : GetParam().hands);
    EXPECT_EQ(end.hello.flags, GetParam().hands == 0 ? HAPTABLE_LINE_TOOL : 0);
    EXPECT_EQ(end.hello.hash, scene.model->hash);
    EXPECT_EQ(end.put(frame_of(end.hello, 5)), frame_of(end.hello, 5));
    haptable_line_hello other = end.hello, said = end.hello;
    --other.version;
    said.flags |= HAPTABLE_LINE_OTHER_VERSION;
    EXPECT_EQ(end.put(frame_of(other, 6)), frame_of(said, 6)) << "a host of before";
    EXPECT_TRUE(put(1, PointsPath(1).at(0)).empty());
    EXPECT_EQ(ticks(), 0U);
    EXPECT_EQ(end.put(frame_of(end.hello, 7)), frame_of(end.hello, 7));
    EXPECT_FALSE(put(1, PointsPath(1).at(0)).empty());
}

// States of another kind of scene: not answered, no tick.
TEST_P(LineOfPoints, AStateThatDoesNotFitTheSceneIsNone) {
    const PointsState state = PointsPath(1).at(0);
    for (const int fingers : {1, 2})
        EXPECT_TRUE(end.put(frame_of(hello_of_hands(fingers), haptable_line_state{}, 1)).empty()) << fingers;
    for (int hands = 3; hands <= HAPTABLE_HANDS; ++hands)
        EXPECT_EQ(end.put(points_state_frame(1, hello_of_hands(hands), state)).empty(), hands != GetParam().hands);
    EXPECT_EQ(end.put(points_state_frame(1, kToolHello, state)).empty(), GetParam().hands != 0);
    EXPECT_EQ(ticks(), 1U);
    // What is longer than a state of this scene does not swallow one that comes after it.
    EXPECT_FALSE(
        end.put(points_state_frame(1, hello_of_hands(8), state) + points_state_frame(2, end.hello, state)).empty());
}

}  // namespace
}  // namespace haptable::test
