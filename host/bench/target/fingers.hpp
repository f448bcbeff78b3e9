// SPDX-License-Identifier: GPL-2.0-or-later
// What a tick of two fingers takes beside a tick of one, in every mode.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/report/numbers.hpp"

namespace haptable {

/// Cube on a Cortex-M7, its top touched: instructions of the ticks with contact before and after, of one finger and of
/// two on the same strokes.
///   build  where `make images` has left the cube's image; tables are made below it
NumberTable finger_costs(const std::filesystem::path& build);

/// Parts at the clock that they are sold with on which every tick ends within 90 % of a millisecond, at an instruction
/// a clock: by the bound, or by all that were counted.
std::string parts_in_time(std::uint64_t bound, std::uint64_t worst);

}  // namespace haptable
