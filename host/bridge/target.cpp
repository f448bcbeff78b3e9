// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bridge/target.hpp"

namespace haptable {

/// One burst: states of a tick arrive together.
void SerialTarget::send(std::uint32_t sequence, const TargetStates& states) {
    std::array<std::uint8_t, kFingers * HAPTABLE_FRAME_BYTES> bytes{};
    const int of_both = states[0] && states[1] ? 1 : 0;
    std::size_t length = 0;
    for (std::size_t finger = 0; finger < kFingers; ++finger)
        if (states[finger])
            length += haptable_frame_write_state_of(static_cast<int>(finger), of_both, sequence, &*states[finger],
                                                    bytes.data() + length);
    line_.write(std::span(bytes.data(), length));
}

void SerialTarget::ask(std::uint32_t sequence) {
    std::array<std::uint8_t, HAPTABLE_FRAME_BYTES> bytes{};
    line_.write(std::span(bytes.data(), haptable_frame_write_ask(sequence, bytes.data())));
}

std::optional<TargetForce> SerialTarget::take() {
    for (;;) {
        if (begin_ == end_) {
            begin_ = 0;
            end_ = line_.read(buffer_);
            if (end_ == 0) return std::nullopt;
        }
        haptable_frame whole{};
        if (haptable_frame_read(&reader_, buffer_[begin_++], &whole) == 0) continue;
        if (haptable_body_state pose{}; haptable_frame_take_pose(&whole, &pose) != 0) {
            pose_sequence_ = whole.sequence;
            pose_ = pose;
            continue;
        }
        haptable_swings swings{};
        if (const int modes = haptable_frame_take_modes(&whole, &swings); modes > 0) {
            swings_sequence_ = whole.sequence;
            swings_ = swings;
            modes_ = modes;
            continue;
        }
        TargetForce force;
        force.sequence = whole.sequence;
        force.output.patch = HAPTABLE_NONE;
        int finger = 0;
        if (haptable_frame_take_force_of(&whole, &finger, &force.model_hash, &force.output) != 0) {
            force.finger = static_cast<std::size_t>(finger);
            if (pose_sequence_ == whole.sequence) force.body = pose_;
            if (swings_sequence_ == whole.sequence) force.swings = swings_;
            force.modes = modes_;
            return force;
        }
        ++foreign_frames_;
    }
}

}  // namespace haptable
