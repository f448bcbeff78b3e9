// SPDX-License-Identifier: GPL-2.0-or-later
// The body itself, for any mesh: 10-node tetrahedra on the mesh or on one whose tetrahedra are cut into eight.
#pragma once

#include "host/bench/error/footprint.hpp"
#include "host/mesh/mesh.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

/// Every tetrahedron in eight: four at the corners, the octahedron between them along its shortest diagonal. Of the
/// mesh's own shape, with the mesh's nodes first. Groups are left out.
TetMesh in_eight(const TetMesh& mesh);

/// A mesh whose edges have a node in their middle, straight. Of each tetrahedron the corners, then the nodes between
/// 01 12 20 03 13 23; of each surface triangle the corners, then those between 01 12 20 (CalculiX's order).
struct QuadraticMesh {
    std::vector<Eigen::Vector3d> position_m;
    std::vector<std::array<std::int32_t, 10>> tet;
    std::vector<std::array<std::int32_t, 6>> triangle;
    std::vector<std::int32_t> unknown;  ///< place among the free nodes, -1: held
    std::int32_t free_count = 0;
};
/// Held where the scene's boxes hold it; the scene's material alone.
QuadraticMesh make_quadratic(const Scene& scene, const TetMesh& mesh);

/// Where an element resists a change of volume.
enum class Volume {
    kEverywhere,  ///< the textbook's (C3D10): never softer than the body, and too stiff near Poisson's ratio 0.5
    kOnAverage,   ///< one pressure an element (Crouzeix and Raviart 1973): stable for any ratio, too soft if anything
};

/// K of its free nodes, N/m.
Eigen::SparseMatrix<double> assemble_quadratic(const QuadraticMesh& mesh, const Material& material,
                                               Volume volume = Volume::kEverywhere);

/// A footprint's pressure against the quadratic shape functions of the surface.
LoadShares shares_on(const QuadraticMesh& mesh, const Footprint& footprint);

}  // namespace haptable
