// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>

#include "host/numbers/numbers.hpp"

namespace haptable {

/// What a step costs in each mode, over the paper's, and how many bytes its tables have; on the cube and the mouse,
/// sliding 2 mm deep. `repetitions` of each timing: the median counts.
NumberTable cost_of_modes(const std::filesystem::path& build, int repetitions);

}  // namespace haptable
