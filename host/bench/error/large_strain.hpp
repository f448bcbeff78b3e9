// SPDX-License-Identifier: GPL-2.0-or-later
// How deep a linear body may be touched: against CalculiX with a neo-Hookean material and large deformation on the same
// mesh under the same load, and what haptable-precompute expects of it from the linear body alone.
#pragma once

#include <filesystem>

#include "host/base/progress.hpp"
#include "host/numbers/numbers.hpp"

namespace haptable {

struct LargeStrain {
    NumberTable limits;  ///< displacement at which the linear force is 5, 10, 20 % off, found and expected, by way
    NumberTable curve;   ///< body, way, displacement, force over the linear one, the same as expected
};

/// Cubes, the mouse and the liver, pressed, pulled and pushed sideways. Many minutes.
LargeStrain large_strain(const std::filesystem::path& build, Progress& progress);

}  // namespace haptable
