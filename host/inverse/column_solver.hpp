// SPDX-License-Identifier: GPL-2.0-or-later
// Columns of L = K^-1 at chosen rows, from the supernodal factor, doing only what the chosen entries need.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/base/progress.hpp"
#include "host/base/workers.hpp"
#include "host/inverse/factor.hpp"
#include "host/solve/tree_solver.hpp"

namespace haptable {

/// Solves K X = E for unit loads on groups of nodes that are near in the elimination tree, so that a group shares its
/// way to the root. Forward: only supernodes on that way. Backward: only supernodes that lead to wanted rows; and, as
/// L_ri = L_ir^T, of rows that are columns too only those from the group's first supernode on: earlier ones come
/// from the earlier groups' own columns.
class ColumnSolver {
public:
    /// node: [n] unknown nodes whose columns are wanted; row: [r] unknown nodes whose rows are. No node twice.
    ColumnSolver(const Supernodes& factor, std::span<const std::int32_t> node, std::span<const std::int32_t> row);

    /// Where the blocks go. Groups are the unit of work: a group's blocks are its own, and no other group gives them.
    struct Sink {
        /// Takes L_ri = `block` (m/N) with r = row[k] and i = node[c]. Called by several workers at once.
        std::function<void(std::size_t c, std::size_t k, const Eigen::Matrix3f& block)> take;
        std::function<void(std::size_t group)> done;  ///< all blocks of a group are taken; one call at a time
        std::function<bool(std::size_t group)> have;  ///< true: the group is not computed; asked before any work
    };
    /// Computes every wanted block in precision T, each once. The number of workers changes no bit. Returns the
    /// multiplications and additions that were done.
    template <typename T>
    double compute(Progress& progress, const Sink& sink, Workers* workers = nullptr) const;

    /// Calls visit(c, k) for every block that a group gives, in a fixed order.
    void for_each_block(std::size_t group, const std::function<void(std::size_t c, std::size_t k)>& visit) const;
    std::size_t group_count() const { return group_.size(); }
    double flops(std::size_t group) const { return group_[group].flops; }

    double flops() const { return flops_; }  ///< multiplications and additions of compute() for all groups
    /// Bytes that compute<T>() needs; in float it keeps a copy of the factor.
    template <typename T>
    double bytes(int workers = 1) const;

private:
    static constexpr std::size_t kGroup = 128;  // nodes: 384 right-hand sides; narrower ones leave BLAS short of work
    /// Nodes that are solved for together.
    struct Group {
        std::vector<std::int32_t> column;  // of the table, in the order of the factor
        std::int32_t first_supernode = 0;  // that holds any of them
        std::vector<std::int32_t> path;    // supernodes of the forward solve, ascending
        std::vector<std::int32_t> back;    // of the backward solve, ascending
        std::vector<std::int32_t> all;     // either
        double flops = 0.0;
    };
    std::vector<Group> make_groups(std::span<const std::int32_t> node) const;
    void find_solves(Group& group) const;
    int active(const Group& group, std::int32_t s) const;
    double count(const Group& group) const;
    template <typename T>
    void solve(const Group& group, TreeSolver<T>& x) const;
    /// visit(k, c, given): row k and place c in the group; `given`: whether the transposed block is this group's too.
    template <typename Visit>
    void visit_blocks(const Group& group, Visit visit) const;
    template <typename T>
    void hand_out(const Group& group, const TreeSolver<T>& x, const Sink& sink) const;

    Supernodes factor_;
    EliminationTree tree_;
    std::vector<std::int32_t> node_, row_;     // as given
    std::vector<std::int32_t> column_of_row_;  // [r] where a row is a column too, or -1
    std::vector<std::int32_t> row_of_column_;  // [n] and the other way round
    std::vector<std::int32_t> first_of_;       // [n] first supernode of the column's group
    std::vector<char> needed_, always_;        // [supernodes] leads to any wanted row; to one that is no column
    std::vector<Group> group_;
    double flops_ = 0.0;
};

}  // namespace haptable
