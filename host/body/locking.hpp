// SPDX-License-Identifier: GPL-2.0-or-later
// How much too stiff linear tetrahedra are near incompressibility: each may not change its volume, and a mesh of them
// can hardly move.
#pragma once

#include <string>
#include <vector>

#include "host/body/body.hpp"
#include "host/body/mask.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

/// By which fraction linear tetrahedra make a finger feel a scene too stiff: 0 for elements that do not lock.
struct Locking {
    double excess = 0.0;
    double finger_radius_m = 0.0;  ///< of the finger's pad
    std::size_t places = 0;        ///< whose most it is; 0: it is foreseen from the mesh alone
};

/// Radius of a finger's pad, where this is asked: the mask's, or a sixth of the body.
double pad_radius_m(const Scene& scene, const TetMesh& mesh);

/// A law fitted to the paper's cube, whose grid is kinder than most: within a fourth there, for Poisson's ratio of 0.45
/// and more and edges up to the radius; other meshes lock more, up to many times (docs/design/elements.md).
double expected_locking(double poisson, double edge_m, double radius_m);

/// By that law: of the most incompressible material, the mesh's mean edge, and the mask's radius or a sixth of the
/// body.
Locking foresee_locking(const Scene& scene, const TetMesh& mesh);

/// On the body itself: how much stiffer the masks of a few touchable nodes, or pads around them, are at most than by
/// average nodal pressure on the same mesh. From below, and within a tenth at Poisson's ratio 0.4999. Foreseen where it
/// cannot lock, and under prestress.
///   masks   of the scene; unused without a mask
///   solver  of its K
Locking measure_locking(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver);

/// "scene.toml: linear tetrahedra lock at Poisson's ratio 0.49: ...": where it is felt.
std::vector<std::string> locking_warnings(const Scene& scene, const Locking& locking);

}  // namespace haptable
