// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "host/base/scene_options.hpp"
#include "host/scene/section.hpp"

namespace haptable {

/// What the scene file says and every default that stands for what it does not say. Throws Error with line and key for
/// an unknown key, a wrong type, an impossible value, and keys that exclude or need each other (keys.hpp). A material's
/// values are as they stand: read_material() judges them.
SceneOptions read_options(const Section& root);

/// The options of a scene that says nothing.
SceneOptions default_options();

}  // namespace haptable
