// SPDX-License-Identifier: GPL-2.0-or-later
// K and M of a scene's body.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/body/body.hpp"
#include "host/fem/stiffness.hpp"
#include "host/inverse/stiffness.hpp"

namespace haptable {

struct NodeWeights;

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

// ---- between the mesh's nodes, as columns [3, N], and the rows of those that are free -------------------------------
// unknown: [N] place of a node among these, or -1

/// Held nodes are 0.
Eigen::Matrix3Xd spread(const Eigen::VectorXd& x, std::span<const std::int32_t> unknown);
/// [size] rows.
Eigen::VectorXd gather(const Eigen::Matrix3Xd& f, std::span<const std::int32_t> unknown, Eigen::Index size);
/// [size, 3] W: how the nodes share a load along each of the three axes.
Eigen::MatrixXd load_matrix(const NodeWeights& load, std::span<const std::int32_t> unknown, Eigen::Index size);

}  // namespace haptable
