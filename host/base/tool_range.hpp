// SPDX-License-Identifier: GPL-2.0-or-later
// How many points a rigid tool may have.
#pragma once

#include <cstddef>

namespace haptable {

constexpr std::size_t kFewestPoints = 2, kMostPoints = 32;  // HAPTABLE_POINTS

}  // namespace haptable
