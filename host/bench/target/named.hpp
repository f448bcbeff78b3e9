// SPDX-License-Identifier: GPL-2.0-or-later
// A scene pays for what it names: one row a scene that names one thing more, or less.
#pragma once

#include <filesystem>

#include "host/report/numbers.hpp"

namespace haptable {

/// Cube and mouse on a Cortex-M7: flash, RAM, stack, instructions a tick, processor time of precompute.
///   build  where `make images` has left the cube's image; tables are made below it
NumberTable named_costs(const std::filesystem::path& build);

}  // namespace haptable
