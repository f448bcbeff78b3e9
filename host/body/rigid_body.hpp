// SPDX-License-Identifier: GPL-2.0-or-later
// What a body that is not held moves like, and how its K is held where that does not matter.
#pragma once

#include <Eigen/SparseCore>
#include <filesystem>

#include "host/body/body.hpp"
#include "host/inverse/stiffness.hpp"

namespace haptable {

/// Mass and inertia of the whole mesh, N nodes. Axes and origin are the mesh's.
struct RigidBody {
    double mass_kg = 0.0;
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();       ///< of mass
    Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about it
    Eigen::MatrixXd motion;    ///< R [3N, 6]: along x, y, z, and about them through the centre
    Eigen::MatrixXd momentum;  ///< M R, M the consistent mass
};

/// The rigid body of a scene with free_body.
RigidBody rigid_body_of(const Scene& scene, const Body& body);

/// Throws Error where mass or inertia are beyond what a servo moves, or the suspension is too fast for it.
void require_movable(const Scene& scene, const RigidBody& rigid);

/// Three nodes, far apart: from the centre, from one another, and from the line of those two.
std::array<std::int32_t, 3> find_holds(const Body& body);

/// Springs that hold six directions at these nodes and no more: the first, the second but along the line to the first,
/// the third across the plane of all. As stiff as K is there. A load in equilibrium meets no reaction.
///   k  of all nodes
Eigen::SparseMatrix<double> hold_springs(const Body& body, const Eigen::VectorXd& k_diagonal);

/// K of the free nodes; of a body that nothing holds K_c, with hold_springs().
Stiffness assemble_held(const Scene& scene, const Body& body);

/// Throws Error where the body does not hang together as one: parts that touch nowhere, or by a hinge.
void require_one_body(const Scene& scene, const Body& body);

/// What the servo reads of it: body.json, in the names of haptable_body.h; with a floor, what of the body rests on it.
void write_rigid_body(const Scene& scene, const Body& body, const RigidBody& rigid,
                      const std::filesystem::path& folder);

}  // namespace haptable
