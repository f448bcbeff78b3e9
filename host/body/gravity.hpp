// SPDX-License-Identifier: GPL-2.0-or-later
// K sag = f,   (K + K_sigma(sag)) u = F
//
// A body that its own weight has loaded before a finger comes. In small strain its stiffness is that of the body
// without weight; what the stress adds to it is told, and taken where the scene asks for it.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "host/body/body.hpp"
#include "host/body/mask.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

struct GravityFacts {
    static constexpr double kFelt = 0.01;    ///< of the force, from which on prestress is worth asking for
    static constexpr double kMostSag = 0.1;  ///< of the body's size, to which its small strain is good
    double weight_n = 0.0;
    double largest_sag_m = 0.0;
    std::int32_t lowest_node = 0;  ///< where that is
    double force_change = 0.0;  ///< largest share by which K_sigma changes the force of a few fingers, to first order
    double load_factor = 0.0;   ///< the multiple of the weight at which the body buckles; 0: it stiffens it everywhere
};

/// [N] m, held nodes 0. The solver's K is assemble_free(). Throws Error where it turns tetrahedra inside out.
std::vector<Eigen::Vector3d> find_sag(const Scene& scene, const Body& body, const LinearSolver& solver);

/// K_sigma of the free nodes under that sag, N/m.
Eigen::SparseMatrix<double> prestress_of(const Scene& scene, const Body& body,
                                         const std::vector<Eigen::Vector3d>& sag_m);

/// The least factor > 0 for which K + factor K_sigma is singular: Lanczos's process on -K^-1 K_sigma in K's own
/// product, with all vectors orthogonal again each step (Bathe, Finite Element Procedures, 11.6). Infinite where there
/// is none. From above, within a few per mille where the body has several unknowns.
double buckling_factor(const Eigen::SparseMatrix<double>& k_sigma, const LinearSolver& solver);

GravityFacts judge_gravity(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver,
                           const std::vector<Eigen::Vector3d>& sag_m, const Eigen::SparseMatrix<double>& k_sigma);

/// Throws Error where the body buckles under its own weight, or less.
void require_unbuckled(const Scene& scene, const GravityFacts& facts);

/// "the body's weight changes the force by up to 3 % ...": where that is felt and not taken; and a sag beyond small
/// strain, of a body in that box.
std::vector<std::string> gravity_warnings(const Scene& scene, const std::optional<GravityFacts>& facts,
                                          const Eigen::AlignedBox3d& box_m);

/// One line for people.
std::string describe(const Scene& scene, const GravityFacts& facts);

}  // namespace haptable
