// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <optional>

#include "host/tables/folder.hpp"

namespace haptable {

/// Depth, m, from which the force of these tables is expected to be more than 10 % off a rubber's, as tables.json of
/// haptable-precompute tells it; none where it does not. Throws Error where there are no tables.
std::optional<double> read_small_strain_depth(const TablesFolder& folder);

}  // namespace haptable
