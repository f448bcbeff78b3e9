// SPDX-License-Identifier: GPL-2.0-or-later
// What a tick of two fingers takes beside a tick of one, in every mode.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/numbers/numbers.hpp"

namespace haptable {

/// Two fingers on a cube.
struct FingerCosts {
    NumberTable costs;  ///< instructions of the ticks with contact before and after, of one finger and of two
    NumberTable rates;  ///< parts on which two run at 5 and 10 kHz
};

/// On a Cortex-M7, the cube's top being touched, by one finger and by two on the same strokes.
///   build  where `make images` has left the cube's image; tables are made below it
FingerCosts finger_costs(const std::filesystem::path& build);

/// Parts at the clock that they are sold with on which every tick ends in that time, at an instruction a clock: by the
/// bound, or by all that were counted; "none" where there is none.
std::string parts_in_time(std::uint64_t bound, std::uint64_t worst, double time_s = 0.9e-3);

}  // namespace haptable
