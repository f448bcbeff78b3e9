// SPDX-License-Identifier: GPL-2.0-or-later
// The servo at the other end of a serial line: states go out as frames, forces come back (SPEC: the serial line).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/haptable_frame_body.h"
#include "firmware/haptable_frame_modes.h"
#include "firmware/haptable_frame_pair.h"
#include "host/link/channels.hpp"
#include "host/link/line.hpp"

namespace haptable {

/// One force as the target sent it.
struct TargetForce {
    std::size_t finger = 0;
    std::uint32_t sequence = 0;    ///< of the state, or of the question, that it answers
    std::uint64_t model_hash = 0;  ///< tables_hash of those that the target runs
    haptable_output output{};      ///< all but `patch`
    /// Where the body was in that tick: all that is on the line. None where the target did not say.
    std::optional<haptable_body_state> body;
    /// How far the modes have swung by its end: q alone; and how many there are. None where it did not say.
    std::optional<haptable_swings> swings;
    int modes = 0;
};

/// A tick's states, by finger; none: it is not in it.
using TargetStates = std::array<std::optional<haptable_frame_state>, kFingers>;

class SerialTarget {
public:
    explicit SerialTarget(Line line) : line_(std::move(line)) { haptable_frame_reader_init(&reader_); }

    void send(std::uint32_t sequence, const TargetStates& states);
    /// Asks whether it knows a second finger: one that does answers with its force and this sequence.
    void ask(std::uint32_t sequence);
    /// The next whole force of those that have come, without waiting. Garbage before it is skipped and counted.
    std::optional<TargetForce> take();

    const Line& line() const { return line_; }
    std::uint64_t skipped_bytes() const { return reader_.skipped_bytes; }  ///< that belonged to no frame
    std::uint64_t foreign_frames() const { return foreign_frames_; }       ///< whole ones of another kind

private:
    Line line_;
    haptable_frame_reader reader_{};
    std::array<std::uint8_t, 512> buffer_{};
    std::size_t begin_ = 0, end_ = 0;  ///< of what of the buffer is unread
    std::uint64_t foreign_frames_ = 0;
    std::uint32_t pose_sequence_ = 0, swings_sequence_ = 0;
    std::optional<haptable_body_state> pose_;  ///< the last one
    std::optional<haptable_swings> swings_;    ///< likewise
    int modes_ = 0;
};

}  // namespace haptable
