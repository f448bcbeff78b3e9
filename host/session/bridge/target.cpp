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

TargetAnswer answer_of(std::uint32_t sequence, const haptable_line_answer& said) {
    TargetAnswer answer;
    answer.sequence = sequence;
    std::copy_n(said.out, HAPTABLE_FINGERS, answer.output.begin());
    answer.body = body_of(said.pose);
    std::copy_n(said.q, HAPTABLE_MODES, answer.modes.q);
    return answer;
}

}  // namespace

SerialTarget::SerialTarget(Line line, const ServoScene& scene) : line_(std::move(line)), scene_(scene) {
    haptable_scene whole{};
    haptable_scene_make(scene.model, scene.pair, scene.body, scene.modes, &whole);
    haptable_line_describe(&whole, &expected_);
    const int payload = HAPTABLE_LINE_ANSWER_PAYLOAD(expected_.fingers, scene.body != nullptr, expected_.modes);
    haptable_line_reader_init(frame_.data(), static_cast<std::uint16_t>(HAPTABLE_LINE_FRAME_BYTES(payload)), &reader_);
}

void SerialTarget::ask() {
    std::array<std::uint8_t, HAPTABLE_LINE_HELLO_BYTES> bytes{};
    line_.write(std::span(bytes.data(), haptable_line_write_hello(0, expected_, bytes.data())));
}

void SerialTarget::send(std::uint32_t sequence, const haptable_line_state& state) {
    std::array<std::uint8_t, HAPTABLE_LINE_STATE_BYTES> bytes{};
    line_.write(std::span(bytes.data(), haptable_line_write_state(sequence, &expected_, state, bytes.data())));
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
        haptable_line_answer answer{};
        if (haptable_line_read(&reader_, buffer_[begin_++], &whole) == 0) continue;
        if (haptable_line_take_hello(&whole, &hello) != 0) return hello;
        if (haptable_line_take_answer(&whole, &expected_, &answer) != 0) return answer_of(whole.sequence, answer);
        ++foreign_frames_;
    }
}

}  // namespace haptable
