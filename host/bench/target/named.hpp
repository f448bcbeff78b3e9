// SPDX-License-Identifier: GPL-2.0-or-later
// A scene pays for what it names: a row a scene that names one thing more, or less.
#pragma once

#include <filesystem>

#include "host/numbers/numbers.hpp"

namespace haptable {

struct NamedCosts {
    NumberTable costs, mouse;  ///< of the cube; of the mouse
    NumberTable precision;     ///< of compliance tables: bytes and worst error of a force, as they may be stored
};

/// Cube and mouse on a Cortex-M7: flash, RAM, stack, instructions a tick, processor time of precompute.
///   build  where `make images` has left the cube's image; tables are made below it
NamedCosts named_costs(const std::filesystem::path& build);

}  // namespace haptable
