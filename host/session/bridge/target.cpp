// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/bridge/target.hpp"

#include <algorithm>

namespace haptable {

namespace {

haptable_body_state body_of(const haptable_body_pose& pose) {
    haptable_body_state body{};
    std::copy_n(pose.position_m, 3, body.position_m);
    std::copy_n(pose.turn, 4, body.turn);
    std::copy_n(pose.velocity_m_per_s, 3, body.velocity_m_per_s);
    std::copy_n(pose.spin_rad_per_s, 3, body.spin_rad_per_s);
    body.on_floor = pose.on_floor;
    return body;
}

bool has_tool(const TargetHello& hello) { return (hello.flags & HAPTABLE_LINE_TOOL) != 0; }
bool has_hands(const TargetHello& hello) { return hello.fingers > HAPTABLE_FINGERS; }

/// Bytes of the longest answer.
std::size_t most_bytes(const ServoScene& scene, const TargetHello& hello) {
    if (scene.tool != nullptr)
        return HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_TOOL_LINE_ANSWER_PAYLOAD(std::size_t{scene.tool->points.count}));
    return HAPTABLE_LINE_FRAME_BYTES(
        HAPTABLE_LINE_ANSWER_PAYLOAD(std::size_t{hello.fingers}, scene.body != nullptr, std::size_t{hello.modes}));
}

}  // namespace

SerialTarget::SerialTarget(Line line, const ServoScene& scene) : line_(std::move(line)), scene_(scene) {
    haptable_scene whole{};
    haptable_scene_make(scene.model, scene.pair, scene.body, scene.modes, &whole);
    if (scene.tool != nullptr)
        haptable_tool_line_describe(&whole, &expected_);
    else
        haptable_line_describe(&whole, &expected_);
    frame_.resize(most_bytes(scene_, expected_));
    haptable_line_reader_init(frame_.data(), static_cast<std::uint16_t>(frame_.size()), &reader_);
}

void SerialTarget::ask() {
    std::array<std::uint8_t, HAPTABLE_LINE_HELLO_BYTES> bytes{};
    line_.write(std::span(bytes.data(), haptable_line_write_hello(0, expected_, bytes.data())));
}

void SerialTarget::send(std::uint32_t sequence, const TargetState& state) {
    std::array<std::uint8_t, HAPTABLE_HANDS_LINE_STATE_BYTES> bytes{};
    line_.write(std::span(bytes.data(), write_state(expected_, sequence, state, bytes.data())));
}

std::uint32_t write_state(const TargetHello& scene, std::uint32_t sequence, const TargetState& state,
                          std::uint8_t bytes[HAPTABLE_HANDS_LINE_STATE_BYTES]) {
    if (has_tool(scene)) {
        haptable_tool_line_state tool{state.time_us, state.begins, {state.in[0], {}}};
        std::copy_n(state.turn.begin(), 4, tool.in.turn);
        return haptable_tool_line_write_state(sequence, &tool, bytes);
    }
    if (has_hands(scene)) {
        haptable_hands_line_state hands{state.time_us, state.begins, {}};
        std::copy_n(state.in.begin(), HAPTABLE_HANDS, hands.in);
        return haptable_hands_line_write_state(sequence, &scene, &hands, bytes);
    }
    haptable_line_state fingers{state.time_us, state.begins, {}};
    std::copy_n(state.in.begin(), HAPTABLE_FINGERS, fingers.in);
    return haptable_line_write_state(sequence, &scene, fingers, bytes);
}

bool take_answer(const haptable_line_frame& frame, const TargetHello& scene, TargetAnswer& answer) {
    answer.sequence = frame.sequence;
    if (has_tool(scene)) {
        if (haptable_tool_line_take_answer(&frame, &answer.tool) == 0) return false;
        answer.output[0] = answer.tool.out.hand;
        return true;
    }
    if (has_hands(scene)) {
        haptable_hands_line_answer hands{};
        if (haptable_hands_line_take_answer(&frame, &scene, &hands) == 0) return false;
        std::copy_n(hands.out, HAPTABLE_HANDS, answer.output.begin());
        return true;
    }
    haptable_line_answer said{};
    if (haptable_line_take_answer(&frame, &scene, &said) == 0) return false;
    std::copy_n(said.out, HAPTABLE_FINGERS, answer.output.begin());
    answer.body = body_of(said.pose);
    std::copy_n(said.q, HAPTABLE_MODES, answer.modes.q);
    return true;
}

std::optional<std::variant<TargetHello, TargetAnswer>> SerialTarget::take() {
    for (;;) {
        if (begin_ == end_) {
            begin_ = 0;
            end_ = line_.read(buffer_);
            if (end_ == 0) return std::nullopt;
        }
        haptable_line_frame whole{};
        TargetHello hello{};
        TargetAnswer answer;
        if (haptable_line_read(&reader_, buffer_[begin_++], &whole) == 0) continue;
        if (haptable_line_take_hello(&whole, &hello) != 0) return hello;
        if (take_answer(whole, expected_, answer)) return answer;
        ++foreign_frames_;
    }
}

}  // namespace haptable
