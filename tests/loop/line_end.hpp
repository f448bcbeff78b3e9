// SPDX-License-Identifier: GPL-2.0-or-later
// A serial line: its frames as bytes, and the servo's end as firmware/port/loop.c has it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "host/session/bridge/target.hpp"

namespace haptable::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// Of who says this of itself, whether it is so or not.
inline Bytes frame_of(const haptable_line_hello& hello, std::uint32_t number = 0) {
    Bytes bytes(HAPTABLE_LINE_HELLO_BYTES);
    bytes.resize(haptable_line_write_hello(number, hello, bytes.data()));
    return bytes;
}
inline Bytes frame_of(const haptable_line_hello& hello, const TargetState& state, std::uint32_t number) {
    Bytes bytes(HAPTABLE_HANDS_LINE_STATE_BYTES);
    bytes.resize(write_state(hello, number, state, bytes.data()));
    return bytes;
}
/// A tool's hand is the first of `output`.
inline Bytes frame_of(const haptable_line_hello& hello, TargetAnswer answer, std::uint32_t number) {
    Bytes bytes(HAPTABLE_TOOL_LINE_ANSWER_BYTES);
    if ((hello.flags & HAPTABLE_LINE_TOOL) != 0) {
        answer.tool.out.hand = answer.output[0];
        bytes.resize(haptable_tool_line_write_answer(number, &answer.tool, bytes.data()));
    } else if (hello.fingers > HAPTABLE_FINGERS) {
        haptable_hands_line_answer hands{};
        std::copy_n(answer.output.begin(), HAPTABLE_HANDS, hands.out);
        bytes.resize(haptable_hands_line_write_answer(number, &hello, &hands, bytes.data()));
    } else {
        haptable_line_answer fingers{};
        std::copy_n(answer.output.begin(), HAPTABLE_FINGERS, fingers.out);
        std::copy_n(answer.body.position_m, 3, fingers.pose.position_m);
        std::copy_n(answer.body.turn, 4, fingers.pose.turn);
        std::copy_n(answer.body.velocity_m_per_s, 3, fingers.pose.velocity_m_per_s);
        std::copy_n(answer.body.spin_rad_per_s, 3, fingers.pose.spin_rad_per_s);
        fingers.pose.on_floor = answer.body.on_floor;
        std::copy_n(answer.modes.q, HAPTABLE_MODES, fingers.q);
        bytes.resize(haptable_line_write_answer(number, &hello, &fingers, bytes.data()));
    }
    return bytes;
}

/// A whole frame; its payload is a copy.
struct Heard {
    haptable_line_frame frame{};
    Bytes payload;
};

/// The receiving end, with room for frames of so many bytes.
class LineEar {
public:
    explicit LineEar(std::uint16_t most = HAPTABLE_TOOL_LINE_ANSWER_BYTES) : room_(most) {
        haptable_line_reader_init(room_.data(), most, &reader_);
    }
    LineEar(const LineEar&) = delete;
    LineEar& operator=(const LineEar&) = delete;

    std::vector<Heard> hear(const Bytes& bytes) {
        std::vector<Heard> all;
        for (const std::uint8_t byte : bytes) {
            Heard one;
            if (haptable_line_read(&reader_, byte, &one.frame) == 0) continue;
            one.payload.assign(one.frame.payload, one.frame.payload + one.frame.length);
            all.push_back(std::move(one));
        }
        for (Heard& one : all) one.frame.payload = one.payload.data();
        return all;
    }
    const haptable_line_reader& reader() const { return reader_; }

private:
    Bytes room_;
    haptable_line_reader reader_{};
};

/// The servo's end.
class LineEnd {
public:
    explicit LineEnd(const ServoScene& scene) : state(state_of(scene)) {
        state.check(HAPTABLE_CHECK_ALL);
        std::uint32_t count = 0;
        const std::uint8_t* bytes = nullptr;
        if (scene.tool != nullptr) {
            haptable_tool_line_describe(&state.scene(), &hello);
            bytes = haptable_tool_line_begin(&state.scene(), &tool_, &count);
        } else {
            haptable_line_describe(&state.scene(), &hello);
            bytes = has_hands() ? haptable_hands_line_begin(&state.scene(), &hands_, &count)
                                : haptable_line_begin(&state.scene(), &fingers_, &count);
        }
        begun.assign(bytes, bytes + count);
    }

    Bytes put(std::uint8_t byte) {
        std::uint32_t count = 0;
        const std::uint8_t* said =
            state.tool() != nullptr ? haptable_tool_line(&state.scene(), state.memory(), &tool_, byte, &count)
            : has_hands()           ? haptable_hands_line(&state.scene(), state.memory(), &hands_, byte, &count)
                                    : haptable_line(&state.scene(), state.memory(), &fingers_, byte, &count);
        EXPECT_EQ(said == nullptr, count == 0);
        return {said, said + count};
    }
    Bytes put(const Bytes& bytes) {
        Bytes all;
        for (const std::uint8_t byte : bytes) all = all + put(byte);
        return all;
    }

    SceneState state;
    haptable_line_hello hello{};  ///< what it says of itself
    Bytes begun;                  ///< what it has said by itself

private:
    bool has_hands() const { return hello.fingers > HAPTABLE_FINGERS; }

    haptable_line_end fingers_{};
    haptable_hands_line_end hands_{};
    haptable_tool_line_end tool_{};
};

}  // namespace haptable::test
