// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bridge/target.hpp"

namespace haptable {

void SerialTarget::send(std::uint32_t sequence, const haptable_frame_state& state) {
    std::array<std::uint8_t, HAPTABLE_FRAME_BYTES> bytes{};
    line_.write(std::span(bytes.data(), haptable_frame_write_state(sequence, &state, bytes.data())));
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
        TargetForce force;
        force.sequence = whole.sequence;
        force.output.patch = HAPTABLE_NONE;
        if (haptable_frame_take_force(&whole, &force.model_hash, &force.output) != 0) return force;
        ++foreign_frames_;
    }
}

}  // namespace haptable
