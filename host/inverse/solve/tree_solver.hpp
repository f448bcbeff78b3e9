// SPDX-License-Identifier: GPL-2.0-or-later
// Triangular solves with the supernodal factor, over chosen supernodes only.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/inverse/solve/supernodes.hpp"

namespace haptable {

/// The elimination tree's maps, found once for all pruned work on a factor.
struct EliminationTree {
    explicit EliminationTree(const Supernodes& factor);

    std::vector<std::int32_t> parent;  ///< [supernodes] or -1
    std::vector<std::int32_t> owner;   ///< [n] supernode of a column of L
    std::vector<std::int32_t> place;   ///< [n] row of L that a row of M became

    /// The least of the supernodes that hold a node's three rows.
    std::int32_t first_of(std::int32_t node) const;
    /// Least row of L of a node's three: the nodes' order along the tree.
    std::int32_t place_of(std::int32_t node) const;
    /// The supernodes that hold the nodes, with all their ancestors, ascending: the way to the root.
    std::vector<std::int32_t> path(std::span<const std::int32_t> nodes) const;
};

/// The right-hand sides of one solve with L S L^T X = B in precision T, at the supernodes that take part. They lie side
/// by side for each row of L (X^T is column-major), so that gathering the rows below a supernode copies whole
/// stretches.
template <typename T>
class TreeSolver {
public:
    /// value: the factor's values in precision T, in the factor's own layout. All three must live on.
    TreeSolver(const Supernodes& factor, const EliminationTree& tree, const T* value);

    /// X = 0 for `width` right-hand sides at these supernodes; every ancestor of one must be among them.
    void begin(std::span<const std::int32_t> supernodes, int width);
    /// X at a row of L: [width].
    T* row(std::int32_t place) { return x_.data() + offset(place); }
    const T* row(std::int32_t place) const { return x_.data() + offset(place); }

    /// X_J <- L_JJ^-1 X_J, X_R <- X_R - L_RJ X_J; of the right-hand sides only the first `active` are not zero here.
    void forward(std::int32_t s, int active);
    /// X_J <- L_JJ^-T (S X_J - L_RJ^T X_R).
    void backward(std::int32_t s);
    int width() const { return width_; }

private:
    std::size_t offset(std::int32_t place) const;
    const T* values(std::int32_t s) const { return value_ + factor_.value_begin[static_cast<std::size_t>(s)]; }

    Supernodes factor_;
    const EliminationTree* tree_;
    const T* value_;
    std::vector<std::size_t> begin_;  // [supernodes] first column of one that takes part
    std::vector<T> x_, below_;
    int width_ = 0;
};

/// Multiplications and additions of forward() or of backward(), for one right-hand side.
double solve_flops(const Supernodes& factor, std::int32_t s);

}  // namespace haptable
