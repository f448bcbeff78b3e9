// SPDX-License-Identifier: GPL-2.0-or-later
// What a servo was asked, tick by tick, read from whatever keeps it: a finger path, a servo's own CSV, an LCM log.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "host/link/messages.hpp"

namespace haptable {

/// A finger in a tick.
struct RecordedFinger {
    std::array<double, 3> position_m{};
    std::uint32_t buttons = 0;
    std::array<float, 4> turn{1.0F, 0.0F, 0.0F, 0.0F};  ///< of a tool, w x y z
    bool begins = false;  ///< a session, or a device that had let go: what was before is forgotten
    std::optional<std::array<float, 3>> force_n = {};  ///< the servo's answer, where the record has it
};

struct RecordedTick {
    std::int64_t number =
        0;  ///< seq of the state, of two fingers the tick's; of a servo's CSV its tick, of a path its line
    std::uint32_t time_us = 0;
    std::array<std::optional<RecordedFinger>, kFingers> finger{};  ///< none: without a device, or silent
};

struct Recording {
    std::vector<RecordedTick> ticks;
    std::size_t fingers = 1;        ///< that are in it
    bool has_tool = false;          ///< of a tool's hand: with its orientation
    bool is_log = false;            ///< of a session; the ticks' numbers are those of states
    std::uint64_t tables_hash = 0;  ///< of the servo that answered; 0: the record does not say
    std::int64_t damaged = 0;       ///< parts of a log that could not be read
};

/// Reads a log: answered states, each once, in the order of their answers; without any answer all states. In
/// lockstep they have the times that the servo had; in real time those of the log, which the servo's came near to.
/// Of several fingers: answers with one utime are one tick, and who was answered is there until its answer says silent.
/// Throws Error for a file that is none of the three.
Recording read_recording(const std::filesystem::path& file);

}  // namespace haptable
