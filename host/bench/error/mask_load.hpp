// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "host/bench/error/footprint.hpp"
#include "host/precompute/mask.hpp"

namespace haptable {

/// The masks of a surface, as precompute makes them.
Masks masks_on(std::span<const Eigen::Vector3d> position_m, std::span<const std::array<std::int32_t, 3>> patch,
               double radius_m);

/// The mask's weights at a point of a patch, in double: w(alpha) of masks.
LoadShares mask_load(const Masks& masks, const std::array<std::int32_t, 3>& patch, const Eigen::Vector3d& alpha);

/// The patch that a point lies on, and its area coordinates there. Throws Error where it lies on none.
std::pair<std::array<std::int32_t, 3>, Eigen::Vector3d> locate(std::span<const Eigen::Vector3d> position_m,
                                                               std::span<const std::array<std::int32_t, 3>> patch,
                                                               const Eigen::Vector3d& x_m);

}  // namespace haptable
