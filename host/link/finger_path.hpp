// SPDX-License-Identifier: GPL-2.0-or-later
// A finger path: a CSV file with the header x,y,z, or x,y,z,buttons, and one position in metres a tick; or a servo's
// own CSV, for its x,y,z and buttons.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace haptable {

/// What a path may hold.
enum class Positions {
    any,    ///< NaN and infinity too: the servo must see them, to reject them
    finite  ///< numbers only: a hand cannot follow anything else
};

/// One line of a path.
struct FingerTick {
    std::array<double, 3> position_m{};
    std::uint32_t buttons = 0;  ///< held down: bits of enum haptable_button
    std::int64_t number = -1;   ///< of a servo's CSV its tick, else -1
};

/// Reads a path. Throws Error "FILE:LINE: ..." for a wrong header, a row that does not have its numbers, and, with
/// Positions::finite, a position that is not finite.
std::vector<FingerTick> read_finger_ticks(const std::filesystem::path& file, Positions allowed);

/// The positions alone, [n,3] in metres.
std::vector<std::array<double, 3>> read_finger_path(const std::filesystem::path& file, Positions allowed);

}  // namespace haptable
