// SPDX-License-Identifier: GPL-2.0-or-later
// Blocks and columns of L = K^-1, from solves of many right-hand sides at once.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/base/progress.hpp"
#include "host/precompute/factor.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

/// Right-hand sides of one solve: three a node. Solving 30 to 300 at once costs a sixth of solving them one by one.
inline constexpr std::size_t kNodesPerBlock = 32;

/// A block of columns of L: x = L[:, nodes first .. first + count - 1 of the table], [3 unknowns, 3 count], m/N.
using TakeColumns = std::function<void(std::size_t first, const Eigen::MatrixXd& x)>;

/// Solves for the columns of all nodes, a block at a time, and hands each block to `take`.
///   k     both triangles stored, [3 unknowns, 3 unknowns]
///   node  [n] places among the unknowns, in table order
/// Returns the largest ||K x - b|| / ||b|| of any right-hand side.
double solve_columns(const Factor& factor, const Eigen::SparseMatrix<double>& k, std::span<const std::int32_t> node,
                     Progress& progress, const TakeColumns& take);

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

/// How far blocks L_ii found one way are from the same blocks in solved columns: ||difference|| / ||L_ii||, largest.
class BlockDifference {
public:
    /// node: [n] places among the unknowns; l_ii: [n] their blocks, m/N.
    BlockDifference(std::span<const std::int32_t> node, std::span<const Eigen::Matrix3d> l_ii)
        : node_(node), l_ii_(l_ii) {}
    void take(std::size_t first, const Eigen::MatrixXd& x);

    double largest = 0.0;

private:
    std::span<const std::int32_t> node_;
    std::span<const Eigen::Matrix3d> l_ii_;
};

/// How far L_ij is from L_ji^T: ||L_ij - L_ji^T|| / sqrt(||L_ii|| ||L_jj||), largest over the pairs of nodes of one
/// block and over all pairs with a node of the first block.
class Asymmetry {
public:
    explicit Asymmetry(std::span<const std::int32_t> node) : node_(node) {}
    void take(std::size_t first, const Eigen::MatrixXd& x);

    double largest = 0.0;

private:
    void compare(std::size_t i, std::size_t j, const Eigen::Matrix3d& l_ij, const Eigen::Matrix3d& l_ji);

    std::span<const std::int32_t> node_;
    Eigen::MatrixXd first_;              // the first block's columns at the nodes of the table, [3 n, 3 kNodesPerBlock]
    std::vector<double> scale_m_per_n_;  // [so far] ||L_ii||
};

/// columns.npy, float32 [n, r, 3, 3]: entry [i, k] is L_ri with r = row k, so that u_r = entry F_i (eq. 8). Mapped into
/// memory, so that what the machine has no room for is on the disk already.
class ColumnFile {
public:
    ColumnFile(const std::filesystem::path& path, std::size_t node_count, std::size_t row_count)
        : row_count_(row_count), file_(path, {node_count, row_count, 3, 3}) {}
    void put(std::size_t i, std::size_t k, const Eigen::Matrix3f& l_ri) {
        Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(&file_.values()[9 * (i * row_count_ + k)]) = l_ri;
    }
    /// Largest ||column - x|| / ||x|| where x is a solved column of node i at the unknown nodes `row`: [3 unknowns, 3].
    double difference(std::size_t i, std::span<const std::int32_t> row, const Eigen::MatrixXd& x) const;

private:
    std::size_t row_count_;
    WritableNpy<float> file_;
};

/// Estimate of the 2-norm condition number of K, good to a few percent: power iteration for the largest eigenvalue,
/// inverse iteration for the smallest.
double estimate_condition(const Eigen::SparseMatrix<double>& k, const Factor& factor);

}  // namespace haptable
