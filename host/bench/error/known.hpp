// SPDX-License-Identifier: GPL-2.0-or-later
// Answers that are known without us: closed forms, and CalculiX.
#pragma once

#include <filesystem>

#include "host/report/numbers.hpp"

namespace haptable {

/// The half-space under a disc and under Hertz's pressure, a bonded layer under a sphere, a cantilever; and CalculiX on
/// the same meshes. A minute or two.
NumberTable known_answers(const std::filesystem::path& build);

/// By how much the linear force is off, against CalculiX with a neo-Hookean material and large deformation on the same
/// mesh and load, as the finger presses, shears and pulls. Many minutes.
struct LargeStrain {
    NumberTable limits;  ///< displacement at which the linear force is 5, 10, 20 % off, by direction
    NumberTable curve;   ///< direction, displacement, force over the linear one
};
LargeStrain large_strain(const std::filesystem::path& build);

}  // namespace haptable
