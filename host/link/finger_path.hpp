// SPDX-License-Identifier: GPL-2.0-or-later
// A finger path: a CSV file with the header x,y,z and one position in metres a tick.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

namespace haptable {

/// What a path may hold.
enum class Positions {
    any,    ///< NaN and infinity too: the servo must see them, to reject them
    finite  ///< numbers only: a hand cannot follow anything else
};

/// Reads a path, [n,3] in metres. Throws Error "FILE:LINE: ..." for a wrong header, a row that is not three numbers,
/// and, with Positions::finite, a position that is not finite.
std::vector<std::array<double, 3>> read_finger_path(const std::filesystem::path& file, Positions allowed);

}  // namespace haptable
