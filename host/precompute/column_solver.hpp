// SPDX-License-Identifier: GPL-2.0-or-later
// Columns of L = K^-1 at chosen rows, from the supernodal factor, doing only what the chosen entries need.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/base/progress.hpp"
#include "host/precompute/factor.hpp"

namespace haptable {

/// Solves K X = E for unit loads on groups of nodes that are near in the elimination tree, so that a group shares its
/// way to the root. Forward: only supernodes on that way. Backward: only supernodes that lead to wanted rows; and, as
/// L_ri = L_ir^T, of rows that are columns too only those from the group's first supernode on: earlier ones come
/// from the earlier groups' own columns.
class ColumnSolver {
public:
    /// node: [n] unknown nodes whose columns are wanted; row: [r] unknown nodes whose rows are. No node twice.
    ColumnSolver(const Supernodes& factor, std::span<const std::int32_t> node, std::span<const std::int32_t> row);

    /// Takes one block: L_ri = `block` (m/N) with r = row[k] and i = node[c].
    using Take = std::function<void(std::size_t c, std::size_t k, const Eigen::Matrix3f& block)>;
    /// Computes every wanted block in precision T, each once, and hands it to `take`, group by group.
    template <typename T>
    void compute(Progress& progress, const Take& take) const;

    double flops() const { return flops_; }  ///< multiplications and additions of compute()
    /// Bytes that compute<T>() needs; in float it keeps a copy of the factor.
    template <typename T>
    double bytes() const;

private:
    static constexpr std::size_t kGroup = 128;  // nodes: 384 right-hand sides; narrower ones leave BLAS short of work
    /// Nodes that are solved for together.
    struct Group {
        std::vector<std::int32_t> column;  // of the table, in the order of the factor
        std::int32_t first_supernode = 0;  // that holds any of them
        std::vector<std::int32_t> path;    // supernodes of the forward solve, ascending
        std::vector<std::int32_t> back;    // of the backward solve, descending
    };
    std::vector<Group> make_groups(std::span<const std::int32_t> node) const;
    void find_solves(Group& group) const;
    int active(const Group& group, std::int32_t s) const;
    double count(const Group& group) const;
    template <typename T>
    class Workspace;
    template <typename T>
    void hand_out(const Group& group, const Workspace<T>& x, const Take& take) const;

    Supernodes factor_;
    std::vector<std::int32_t> parent_, owner_;  // [supernodes], [3 unknowns]
    std::vector<std::int32_t> place_;           // [3 unknowns] row of L
    std::vector<std::int32_t> node_, row_;      // as given
    std::vector<std::int32_t> column_of_row_;   // [r] where a row is a column too, or -1
    std::vector<std::int32_t> row_of_column_;   // [n] and the other way round
    std::vector<std::int32_t> first_of_;        // [n] first supernode of the column's group
    std::vector<char> needed_, always_;         // [supernodes] leads to any wanted row; to one that is no column
    std::vector<Group> group_;
    double flops_ = 0.0;
};

}  // namespace haptable
