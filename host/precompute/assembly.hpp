// SPDX-License-Identifier: GPL-2.0-or-later
// K of a scene's body.
#pragma once

#include <vector>

#include "host/fem/elasticity.hpp"
#include "host/inverse/stiffness.hpp"
#include "host/precompute/body.hpp"

namespace haptable {

/// [T] of each tetrahedron: its region's, or the scene's.
std::vector<Lame> materials_of(const Scene& scene, const Body& body);

/// K of the body's free nodes, in the order of body.free_node.
Stiffness assemble_free(const Scene& scene, const Body& body);

}  // namespace haptable
