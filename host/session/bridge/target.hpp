// SPDX-License-Identifier: GPL-2.0-or-later
// The servo at the other end of a serial line: states go out as frames, answers come back (SPEC: the serial line).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "firmware/haptable_line_points.h"
#include "host/link/line.hpp"
#include "host/link/messages.hpp"
#include "host/session/scene.hpp"

namespace haptable {

/// What the target says of itself.
using TargetHello = haptable_line_hello;

/// A tick as the target gets it.
struct TargetState {
    std::uint32_t time_us = 0;
    std::uint8_t begins = 0;                            ///< a bit for each finger that begins anew
    std::array<haptable_input, kFingers> in{};          ///< of one finger the first
    std::array<float, 4> turn{1.0F, 0.0F, 0.0F, 0.0F};  ///< of a tool
};

/// A tick as the target sent it.
struct TargetAnswer {
    std::uint32_t sequence = 0;                      ///< of the state that it answers
    std::array<haptable_output, kFingers> output{};  ///< all but `patch`; of one finger the first
    haptable_body_state body{};                      ///< where it was in that tick: all that is on the line
    haptable_modes_state modes{};                    ///< how far they have swung by its end: q alone
    haptable_tool_line_answer tool{};                ///< its hand is the first of `output`, too
};

/// Bytes of the frame that a target of the scene takes.
std::uint32_t write_state(const TargetHello& scene, std::uint32_t sequence, const TargetState& state,
                          std::uint8_t bytes[HAPTABLE_HANDS_LINE_STATE_BYTES]);
/// False: the frame is no answer of such a scene.
bool take_answer(const haptable_line_frame& frame, const TargetHello& scene, TargetAnswer& answer);

class SerialTarget {
public:
    /// scene: what the target is to run.
    SerialTarget(Line line, const ServoScene& scene);

    /// Asks the target what it is.
    void ask();
    /// The fingers of a tick.
    void send(std::uint32_t sequence, const TargetState& state);
    /// The next whole frame of those that have come, without waiting. Garbage before it is skipped and counted; so are
    /// answers of another length than the scene's.
    std::optional<std::variant<TargetHello, TargetAnswer>> take();

    const ServoScene& scene() const { return scene_; }
    /// What a target of the scene says.
    const TargetHello& expected() const { return expected_; }
    const Line& line() const { return line_; }
    std::uint64_t skipped_bytes() const { return reader_.skipped_bytes; }  ///< that belonged to no frame
    std::uint64_t foreign_frames() const { return foreign_frames_; }       ///< whole ones of another kind

private:
    Line line_;
    ServoScene scene_;
    TargetHello expected_{};
    std::vector<std::uint8_t> frame_;  ///< room for the longest answer
    haptable_line_reader reader_{};
    std::array<std::uint8_t, 512> buffer_{};
    std::size_t begin_ = 0, end_ = 0;  ///< of what of the buffer is unread
    std::uint64_t foreign_frames_ = 0;
};

}  // namespace haptable
