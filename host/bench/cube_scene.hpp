// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "host/scene/scene.hpp"

namespace haptable {

/// The paper's cube of 30 mm and 10 kPa, its base held, touchable everywhere.
Scene cube_scene(int nodes_per_side, double poisson);

}  // namespace haptable
