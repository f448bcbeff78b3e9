// SPDX-License-Identifier: GPL-2.0-or-later
// K and M of a scene's body.
#pragma once

#include <vector>

#include "host/body/body.hpp"
#include "host/fem/stiffness.hpp"
#include "host/inverse/stiffness.hpp"

namespace haptable {

/// [T] of each tetrahedron: its region's, or the scene's.
std::vector<Lame> materials_of(const Scene& scene, const Body& body);

/// What the body's elements are made of.
struct Laws {
    std::vector<Lame> like;            ///< [T] materials_of()
    std::vector<Hooke> law;            ///< those that are not isotropic, turned
    std::vector<std::int32_t> law_of;  ///< [T] or empty: ElementMesh::law_of
};
Laws laws_of(const Scene& scene, const Body& body);

/// Body and laws must outlive it.
ElementMesh element_mesh(const Scene& scene, const Body& body, const Laws& laws);

/// K of the body's free nodes, in the order of body.free_node.
///   also  added to it, of the same nodes: nothing, or what stress does
Stiffness assemble_free(const Scene& scene, const Body& body, const Eigen::SparseMatrix<double>& also = {});

/// The consistent mass of the same nodes, kg, both triangles. The scene says how heavy the body is.
Eigen::SparseMatrix<double> assemble_mass(const Scene& scene, const Body& body);

}  // namespace haptable
