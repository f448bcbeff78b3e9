// SPDX-License-Identifier: GPL-2.0-or-later
// How much too stiff linear tetrahedra are near incompressibility: each may not change its volume, and a mesh of them
// can hardly move.
#pragma once

#include <string>
#include <vector>

#include "host/precompute/body.hpp"

namespace haptable {

/// By which fraction linear tetrahedra of `edge_m` make a finger's pad of `radius_m` feel too stiff. A law fitted to
/// the cube within a fifth, for Poisson's ratio of 0.45 and more and edges up to the radius (docs/design/elements.md).
double expected_locking(double poisson, double edge_m, double radius_m);

/// The same of a scene: of its most incompressible material, the mesh's mean edge, and the mask's radius or a sixth of
/// the body. 0 for elements that do not lock.
double expected_locking(const Scene& scene, const TetMesh& mesh);

/// "material.poisson = 0.49: linear tetrahedra lock ...": where it is expected to be felt.
std::vector<std::string> locking_warnings(const Scene& scene, const TetMesh& mesh);

}  // namespace haptable
