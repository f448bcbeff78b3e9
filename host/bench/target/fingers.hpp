// SPDX-License-Identifier: GPL-2.0-or-later
// What a tick of two fingers takes beside a tick of one, in every mode.
#pragma once

#include <filesystem>

#include "host/report/numbers.hpp"

namespace haptable {

/// Cube on a Cortex-M7, its top touched: instructions of the ticks with contact before and after, of one finger and of
/// two on the same strokes.
///   build  where `make images` has left the cube's image; tables are made below it
NumberTable finger_costs(const std::filesystem::path& build);

}  // namespace haptable
