// SPDX-License-Identifier: GPL-2.0-or-later
// Columns of L = K^-1 at chosen rows, from the supernodal factor, doing only what the chosen entries need.
#pragma once

#include "host/base/workers.hpp"
#include "host/inverse/inverse.hpp"
#include "host/inverse/solve/tree_solver.hpp"

namespace haptable {

/// Solves K X = E for unit loads on groups of nodes that are near in the elimination tree, so that a group shares its
/// way to the root. Forward: only supernodes on that way. Backward: only supernodes that lead to wanted rows; and, as
/// L_ri = L_ir^T, of rows that are columns too only those from the group's first supernode on: earlier ones come
/// from the earlier groups' own columns.
class ColumnSolver : public Columns {
public:
    /// node, row: as in Inverse::columns(). The number of workers changes no bit. The factor must live on, and its
    /// values may still be missing until compute().
    ColumnSolver(const Supernodes& factor, std::span<const std::int32_t> node, std::span<const std::int32_t> row,
                 Precision precision = Precision::kDouble, Workers* workers = nullptr);

    std::size_t group_count() const override { return group_.size(); }
    void for_each_block(std::size_t group, const Visit& visit) const override;
    ColumnFacts compute(Progress& progress, const Sink& sink) const override;

    double flops(std::size_t group) const { return group_[group].flops; }
    double flops() const { return flops_; }  ///< multiplications and additions of compute() for all groups
    /// That compute() needs; in float it keeps a copy of the factor.
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
    ColumnFacts compute_in(Progress& progress, const Sink& sink) const;
    template <typename T>
    void solve(const Group& group, TreeSolver<T>& x) const;
    /// visit(k, c, given): row k and place c in the group; `given`: whether the transposed block is this group's too.
    template <typename Each>
    void visit_blocks(const Group& group, Each visit) const;
    template <typename T>
    void hand_out(const Group& group, const TreeSolver<T>& x, const Sink& sink) const;

    Precision precision_;
    Workers* workers_;  // null: this thread
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
