// SPDX-License-Identifier: GPL-2.0-or-later
// Whether a hand will feel it: what a press costs at a typical place, beside what the device can give and what it
// hides.
#pragma once

#include <filesystem>
#include <string>

#include "host/scene/scene.hpp"

namespace haptable {

/// What the free touchable nodes (or, with a mask, contacts at them) resist a push with, N/m: the mean over directions.
struct PressStiffness {
    double typical_n_per_m = 0.0;  ///< the median
    double largest_n_per_m = 0.0;  ///< in its stiffest direction
};

/// The depth that is spoken of, m.
inline constexpr double kPress_m = 0.005;

/// From the tables in `folder`. Throws Error that names the file.
PressStiffness press_stiffness(const Scene& scene, const std::filesystem::path& folder);

/// One line: what kPress_m cost in N, against the device's friction and largest force, and what would make it fit.
std::string describe(const PressStiffness& press, const Scene& scene);

}  // namespace haptable
