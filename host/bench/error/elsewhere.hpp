// SPDX-License-Identifier: GPL-2.0-or-later
// What each element is worth under other fingers, at other places and on other bodies than those it was chosen on.
#pragma once

#include <filesystem>

#include "host/base/progress.hpp"
#include "host/numbers/numbers.hpp"

namespace haptable {

/// Masks on the cube, a plate, a ball and the mouse beside the bodies themselves, at Poisson's ratios of 0.3, 0.49 and
/// 0.4999. Meshes are written below `build`. Many minutes.
NumberTable measure_elsewhere(const std::filesystem::path& build, Progress& progress);

}  // namespace haptable
