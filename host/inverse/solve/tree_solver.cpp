// SPDX-License-Identifier: GPL-2.0-or-later
// X_J <- L_JJ^-1 X_J,  X_R <- X_R - L_RJ X_J  up the tree;   X_J <- L_JJ^-T (S X_J - L_RJ^T X_R)  down again
//
// J: columns of a supernode, R: its rows below.
#include "host/inverse/solve/tree_solver.hpp"

#include <algorithm>

#include "host/inverse/solve/blas.hpp"

namespace haptable {

EliminationTree::EliminationTree(const Supernodes& factor)
    : parent(factor.parents()), owner(factor.owners()), place(factor.places()) {}

std::int32_t EliminationTree::place_of(std::int32_t node) const {
    const std::int32_t* rows = &place[at(3 * node)];
    return std::min({rows[0], rows[1], rows[2]});
}

std::int32_t EliminationTree::first_of(std::int32_t node) const { return owner[at(place_of(node))]; }

std::vector<std::int32_t> EliminationTree::path(std::span<const std::int32_t> nodes) const {
    std::vector<std::int32_t> supernodes;
    std::vector<char> seen(parent.size(), 0);
    for (std::int32_t node : nodes)
        for (int d = 0; d < 3; ++d)
            for (std::int32_t s = owner[at(place[at(3 * node + d)])]; s >= 0 && !seen[at(s)]; s = parent[at(s)]) {
                seen[at(s)] = 1;
                supernodes.push_back(s);
            }
    std::sort(supernodes.begin(), supernodes.end());
    return supernodes;
}

double solve_flops(const Supernodes& factor, std::int32_t s) {
    const double columns = factor.column_count(s), rows = static_cast<double>(factor.rows(s).size());
    return columns * (columns + 2.0 * (rows - columns));
}

template <typename T>
TreeSolver<T>::TreeSolver(const Supernodes& factor, const EliminationTree& tree, const T* value)
    : factor_(factor), tree_(&tree), value_(value), begin_(tree.parent.size()) {}

template <typename T>
void TreeSolver<T>::begin(std::span<const std::int32_t> supernodes, int width) {
    width_ = width;
    std::size_t columns = 0;
    for (std::int32_t s : supernodes) {
        begin_[at(s)] = columns;
        columns += at(factor_.column_count(s));
    }
    x_.assign(columns * at(width), T(0));
}

template <typename T>
std::size_t TreeSolver<T>::offset(std::int32_t place) const {
    const std::int32_t s = tree_->owner[at(place)];
    return (begin_[at(s)] + at(place - factor_.first_column[at(s)])) * at(width_);
}

template <typename T>
void TreeSolver<T>::forward(std::int32_t s, int active) {
    const auto rows = static_cast<int>(factor_.rows(s).size());
    const int columns = factor_.column_count(s), below = rows - columns;
    T* x_j = row(factor_.first_column[at(s)]);
    if (width_ == 1)
        blas::trsv_lower('N', columns, values(s), rows, x_j);
    else
        blas::trsm_lower('R', 'T', active, columns, values(s), rows, x_j, width_);
    if (below == 0) return;
    below_.resize(at(active) * at(below));
    if (width_ == 1)
        blas::gemv('N', below, columns, T(1), values(s) + columns, rows, x_j, T(0), below_.data());
    else
        blas::gemm('N', 'T', active, below, columns, T(1), x_j, width_, values(s) + columns, rows, T(0), below_.data(),
                   active);
    const T* from = below_.data();
    for (int place : factor_.rows(s).subspan(at(columns))) {
        T* to = row(place);
        for (int c = 0; c < active; ++c) to[c] -= from[c];
        from += active;
    }
}

template <typename T>
void TreeSolver<T>::backward(std::int32_t s) {
    const auto rows = static_cast<int>(factor_.rows(s).size());
    const int columns = factor_.column_count(s), below = rows - columns;
    T* x_j = row(factor_.first_column[at(s)]);
    for (T* x = x_j + at(factor_.positive_count(s)) * at(width_); x < x_j + at(columns) * at(width_); ++x) *x = -*x;
    if (below > 0) {
        below_.resize(at(width_) * at(below));
        T* to = below_.data();
        for (int place : factor_.rows(s).subspan(at(columns))) to = std::copy_n(row(place), width_, to);
        if (width_ == 1)
            blas::gemv('T', below, columns, T(-1), values(s) + columns, rows, below_.data(), T(1), x_j);
        else
            blas::gemm('N', 'N', width_, columns, below, T(-1), below_.data(), width_, values(s) + columns, rows, T(1),
                       x_j, width_);
    }
    if (width_ == 1)
        blas::trsv_lower('T', columns, values(s), rows, x_j);
    else
        blas::trsm_lower('R', 'N', width_, columns, values(s), rows, x_j, width_);
}

template class TreeSolver<double>;
template class TreeSolver<float>;

}  // namespace haptable
