// SPDX-License-Identifier: GPL-2.0-or-later
// A body under the bench, and a finger that slides over it.
#pragma once

#include <array>
#include <vector>

#include "codegen/loaded_scene.hpp"

namespace haptable {

using FingerPath = std::vector<std::array<float, 3>>;  ///< [ticks] positions, m

/// A closed circle over the upper side, `ticks` positions `depth_m` under the surface (above it where negative).
/// A finger that begins above it and then follows it, over and over, stays in contact.
FingerPath circle(const Tables& tables, double depth_m, std::size_t ticks);

/// The servo after a finger came from above on to a path's first position.
haptable_servo touched(const haptable_model& model, const FingerPath& path);

}  // namespace haptable
