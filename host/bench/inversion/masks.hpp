// SPDX-License-Identifier: GPL-2.0-or-later
// What the tables of a pressure mask cost, and how that grows.
#pragma once

#include <filesystem>
#include <span>

#include "host/numbers/numbers.hpp"

namespace haptable {

/// A row for each cube of 30 mm with that many nodes a side under a mask of 4 mm, and two for each scene that has a
/// mask, of linear and of quadratic tetrahedra: CPU seconds of one thread for all that the mask adds to a run, and
/// those of a dense product of as many operations as it counts. Tables are written below `build`.
NumberTable mask_costs(std::span<const int> sides, std::span<const std::filesystem::path> scenes,
                       const std::filesystem::path& build);

}  // namespace haptable
