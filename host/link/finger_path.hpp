// SPDX-License-Identifier: GPL-2.0-or-later
// A finger path: a CSV file with the header x,y,z, or x,y,z,buttons, and one position in metres a tick; of more fingers
// x,y,z,x2,y2,z2,..., or with ,buttons,buttons2,... behind; of a tool x,y,z,qw,qx,qy,qz, or with ,buttons; or a servo's
// own CSV, for these.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haptable {

/// What names of a finger's columns end with: "", "2", "3".
inline std::string column_suffix(std::size_t finger) { return finger == 0 ? "" : std::to_string(finger + 1); }

/// What a path may hold.
enum class Positions {
    any,    ///< NaN and infinity too: the servo must see them, to reject them
    finite  ///< numbers only: a hand cannot follow anything else
};

/// A finger in a line of a path.
struct FingerPlace {
    std::array<double, 3> position_m{};
    std::uint32_t buttons = 0;  ///< held down: bits of enum haptable_button
    bool is_away = false;       ///< of a servo's CSV of several: without a device, or silent
};

/// One line of a path.
struct FingerTick : FingerPlace {
    std::int64_t number = -1;                        ///< of a servo's CSV its tick, else -1
    std::optional<std::array<double, 4>> turn = {};  ///< of a tool, from its axes to the world's: w x y z
    std::vector<FingerPlace> others = {};            ///< fingers 2 and on

    std::size_t fingers() const { return 1 + others.size(); }
    const FingerPlace& finger(std::size_t i) const { return i == 0 ? *this : others[i - 1]; }
};

/// Reads a path. Throws Error "FILE:LINE: ..." for a wrong header, a row that does not have its numbers, and, with
/// Positions::finite, a position that is not finite.
std::vector<FingerTick> read_finger_ticks(const std::filesystem::path& file, Positions allowed);

/// The positions alone, [n,3] in metres.
std::vector<std::array<double, 3>> read_finger_path(const std::filesystem::path& file, Positions allowed);

}  // namespace haptable
