// SPDX-License-Identifier: GPL-2.0-or-later
// Answers that are known without us: closed forms, and CalculiX.
#pragma once

#include <filesystem>

#include "host/base/progress.hpp"
#include "host/numbers/numbers.hpp"

namespace haptable {

/// The half-space under a disc and under Hertz's pressure, a bonded layer under a sphere, a cantilever; and CalculiX on
/// the same meshes. Minutes.
NumberTable known_answers(const std::filesystem::path& build, Progress& progress);

}  // namespace haptable
