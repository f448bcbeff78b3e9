// SPDX-License-Identifier: GPL-2.0-or-later
// Whose tables build/<name> holds: scene.path in it says, so that two scenes of one name do not overwrite each other's.
#pragma once

#include <filesystem>

#include "host/scene/scene.hpp"

namespace haptable {

/// Throws Error where the folder is that of another scene file, which is still there and has the same name.
void require_own(const std::filesystem::path& folder, const Scene& scene);

/// Writes scene.path where it says something else. before: the folder is haptable's own.
void note_owner(const std::filesystem::path& folder, const Scene& scene);

}  // namespace haptable
