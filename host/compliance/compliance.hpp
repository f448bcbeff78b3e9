// SPDX-License-Identifier: GPL-2.0-or-later
// Blocks and columns of L = K^-1, from solves of many right-hand sides at once.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/base/progress.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

/// Nodes of one solve, with three right-hand sides each. Solving 30 to 300 at once costs a sixth of solving them one by
/// one; more would need more memory than the inversion does.
inline constexpr std::size_t kNodesPerBlock = 16;

/// A block of columns of L: x = L[:, nodes first .. first + count - 1 of the table], [3 unknowns, 3 count], m/N.
using TakeColumns = std::function<void(std::size_t first, const Eigen::MatrixXd& x)>;

/// Solves for the columns of all nodes, a block at a time, and hands each block to `take`.
///   node  [n] places among the unknowns, in table order
/// Returns the largest ||K x - b|| / ||b|| of any right-hand side.
double solve_columns(const LinearSolver& solver, const Stiffness& k, std::span<const std::int32_t> node,
                     Progress& progress, const TakeColumns& take);

/// Condition of a symmetric block, 2-norm; infinite where it is not positive definite.
double condition_of(const Eigen::Matrix3d& block);

/// What the servo needs of L: its 3x3 diagonal blocks, inverted.
class NodeStiffness {
public:
    /// Adds S_i = (L_ii)^-1 of one node; l_ii is symmetric. Throws Error that names the mesh node where L_ii is not
    /// positive definite.
    void add(std::int32_t mesh_node, const Eigen::Matrix3d& l_ii);

    std::vector<Eigen::Matrix3d> stiffness_n_per_m;  ///< in the order of add(), symmetric to the last bit
    double smallest_eigenvalue_m_per_n = 0.0;        ///< of any L_ii
    double largest_condition = 0.0;                  ///< of any L_ii, 2-norm
};

/// How far L_ij is from L_ji^T: ||L_ij - L_ji^T|| / sqrt(||L_ii|| ||L_jj||), largest over all pairs of nodes.
///   l  [3 m, 3 m] at m nodes
double largest_asymmetry(const Eigen::MatrixXd& l);

/// Estimate of the 2-norm condition number of K from below, by Lanczos's method for the largest eigenvalue of K and of
/// K^-1: at most 40 products and 40 solves, fewer once three steps together change either by less than 1 %.
double estimate_condition(const Stiffness& k, const LinearSolver& solver);

/// Least eigenvalue of D^-1/2 K D^-1/2, D the diagonal of K, by Lanczos's method on the inverse: at most 40 solves, to
/// about 1 % from above. No Cholesky factor of K, in any order, has a pivot l_jj^2 / k_jj below it: pivots are entries
/// of Schur complements, whose eigenvalues are not below the matrix's own.
double least_scaled_eigenvalue(const Stiffness& k, const LinearSolver& solver);

/// The largest over the least eigenvalue of D^-1/2 K D^-1/2: what K magnifies roundings by. Elements of different sizes
/// and materials, which the condition of K itself counts, cost no digits (van der Sluis 1969). Twice 40 steps at most.
double estimate_scaled_condition(const Stiffness& k, const LinearSolver& solver);

}  // namespace haptable
