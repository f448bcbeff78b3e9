// SPDX-License-Identifier: GPL-2.0-or-later
// A body as its own weight moves it from its shape without.
#pragma once

#include <filesystem>
#include <vector>

#include "host/tables/tables.hpp"

namespace haptable {

struct Sag {
    Tables tables;  ///< of the shape without weight; rows are the nodes that move, all patches shown
    std::vector<float> displacement_m;  ///< [r,3] of the rows
};

/// The sag of tables in `folder`. Throws Error where their scene has no [gravity].
Sag read_sag(Tables tables, const TablesFolder& folder);

}  // namespace haptable
