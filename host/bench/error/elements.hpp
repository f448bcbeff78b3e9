// SPDX-License-Identifier: GPL-2.0-or-later
// What each element is worth: its mask's stiffness beside the body's, its cost, and how far linear ones lock where the
// law that haptable-precompute warns by was not fitted.
#pragma once

#include <filesystem>

#include "host/base/progress.hpp"
#include "host/numbers/numbers.hpp"

namespace haptable {

struct ElementTables {
    NumberTable worth;    ///< of a mask of 5 mm on the cube, by element, mesh and Poisson's ratio; CPU time of K^-1
    NumberTable locking;  ///< of linear elements: expected, and measured against quadratic ones on the same mesh
};

/// The cube, the mouse and the liver. A minute or two.
///   known  docs/numbers.json, with the truth
ElementTables measure_elements(const std::filesystem::path& known, const std::filesystem::path& build,
                               Progress& progress);

}  // namespace haptable
