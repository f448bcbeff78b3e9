// SPDX-License-Identifier: GPL-2.0-or-later
// What the tables of a pressure mask cost, and how that grows.
#pragma once

#include <span>

namespace haptable {

/// Prints a row for each cube of 30 mm with that many nodes a side under a mask of 4 mm: CPU seconds of one thread, and
/// those of a dense product of as many operations.
void print_mask_costs(std::span<const int> sides);

}  // namespace haptable
