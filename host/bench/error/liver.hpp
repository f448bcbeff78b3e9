// SPDX-License-Identifier: GPL-2.0-or-later
// What each part of a scene is worth to the force: the liver of meshes/liver-capsule.toml, its parts one after the
// other.
#pragma once

#include <filesystem>

#include "host/base/progress.hpp"
#include "host/numbers/numbers.hpp"

namespace haptable {

/// The force of 5 mm of press at the top, pressed at 20 mm/s and held for 0.1 s, and the bytes of the servo's tables, a
/// row a part. Tables are written below `build`. Some ten seconds. Throws Error where precompute does.
NumberTable liver_parts(const std::filesystem::path& build, Progress& progress);

}  // namespace haptable
