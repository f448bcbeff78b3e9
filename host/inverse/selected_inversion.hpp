// SPDX-License-Identifier: GPL-2.0-or-later
// Chosen 3x3 blocks of L = K^-1 from the Cholesky factor of K, without one solve: all blocks that lie in the factor's
// pattern, in particular every L_ii and L_ij of every mesh edge, cost about as much as the factorisation.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "host/base/progress.hpp"
#include "host/inverse/factor.hpp"

namespace haptable {

/// [wanted] 1 where all nine entries of the block lie in the factor's pattern.
std::vector<char> find_in_pattern(const Supernodes& factor, std::span<const NodePair> wanted);

/// Finds out once what has to be computed, then computes it in either precision.
class SelectedInversion {
public:
    /// Plans from the factor's pattern alone; values may still be missing. Throws Error that names a pair that lies
    /// outside the pattern (nodes that share no element): such blocks need a solve.
    SelectedInversion(const Supernodes& factor, std::span<const NodePair> wanted);

    /// The wanted blocks in m/N, in the order asked for. T is the precision to compute in: float takes half the time
    /// and half the memory and is good to about 1e-6 of L_ii, on the factor in double. L_ii comes out symmetric to the
    /// last bit. `progress` is told the fraction of the operations that is done. The number of workers changes no bit.
    template <typename T>
    std::vector<Eigen::Matrix3d> compute(Progress& progress, Workers* workers = nullptr) const;

    double flops() const { return flops_; }  ///< multiplications and additions of compute()
    /// Most numbers that compute() holds at once.
    std::size_t stack_entries(int workers = 1) const;

private:
    /// One entry of L to be picked from the front of a supernode: front(row, column) -> target.
    struct Pick {
        std::int32_t supernode, row, column;
        std::int32_t block, entry;  // of the answer: which block, and which of its nine, column by column
    };
    template <typename T>
    class Run;
    void find_picks(std::span<const NodePair> wanted);
    void find_needed();
    void find_order();
    void measure();
    std::size_t small_entries(int workers) const;

    Supernodes factor_;
    std::size_t wanted_count_;
    std::vector<std::int32_t> parent_;          // [supernodes] or -1
    std::vector<char> needed_;                  // [supernodes] leads to a wanted block
    std::vector<std::int32_t> child_count_;     // [supernodes] needed children
    std::vector<std::int32_t> order_;           // needed supernodes, parents before children
    std::vector<Pick> pick_;                    // by supernode
    std::vector<std::size_t> pick_begin_;       // [supernodes + 1]
    std::vector<double> flops_of_;              // [supernodes] 0 where not needed
    std::vector<std::size_t> subtree_entries_;  // [supernodes] most numbers that its subtree holds at once
    double flops_ = 0.0;
    std::size_t most_entries_ = 0;
};

}  // namespace haptable
