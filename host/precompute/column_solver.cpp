// SPDX-License-Identifier: GPL-2.0-or-later
// X_J <- L_JJ^-1 X_J,  X_R <- X_R - L_RJ X_J  up the tree;   X_J <- L_JJ^-T (X_J - L_RJ^T X_R)  down again
//
// J: columns of a supernode, R: its rows below. Right-hand sides are stored side by side for each row of L
// (X^T is column-major), so that gathering the rows R copies whole stretches.
#include "host/precompute/column_solver.hpp"

#include <algorithm>
#include <type_traits>

#include "host/precompute/blas.hpp"

namespace haptable {

namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Marks the supernodes and all their ancestors.
void mark_ancestors(const std::vector<std::int32_t>& parent, std::vector<char>& marked) {
    for (std::size_t s = 0; s < parent.size(); ++s)  // children come before their parents
        if (marked[s] && parent[s] >= 0) marked[at(parent[s])] = 1;
}

}  // namespace

/// The right-hand sides of one group, at the supernodes that are needed, in precision T.
template <typename T>
class ColumnSolver::Workspace {
public:
    explicit Workspace(const ColumnSolver& solver)
        : solver_(solver), factor_(solver.factor_), begin_(solver.parent_.size()) {
        std::size_t columns = 0;
        for (std::int32_t s = 0; s < factor_.count(); ++s) {
            begin_[at(s)] = columns;
            if (solver_.needed_[at(s)]) columns += at(factor_.column_count(s));
        }
        x_.resize(columns * 3 * kGroup);
        if constexpr (!std::is_same_v<T, double>)
            copy_.assign(factor_.value, factor_.value + factor_.value_begin.back());
    }

    void solve(const Group& group) {
        width_ = static_cast<int>(3 * group.column.size());
        std::fill(x_.begin(), x_.end(), T(0));
        for (std::size_t c = 0; c < group.column.size(); ++c)
            for (int d = 0; d < 3; ++d)
                row(solver_.place_[at(3 * solver_.node_[at(group.column[c])] + d)])[3 * c + at(d)] = T(1);
        for (std::int32_t s : group.path) forward(s, solver_.active(group, s));
        for (std::int32_t s : group.back) backward(s);
    }
    /// X at a row of L: [width].
    const T* row(std::int32_t place) const { return x_.data() + offset(place); }

private:
    T* row(std::int32_t place) { return x_.data() + offset(place); }
    std::size_t offset(std::int32_t place) const {
        const std::int32_t s = solver_.owner_[at(place)];
        return (begin_[at(s)] + at(place - factor_.first_column[at(s)])) * at(width_);
    }
    const T* values(std::int32_t s) const {
        if constexpr (std::is_same_v<T, double>)
            return factor_.values(s);
        else
            return copy_.data() + factor_.value_begin[at(s)];
    }

    /// Only the first `active` right-hand sides are not yet zero here.
    void forward(std::int32_t s, int active) {
        const auto rows = static_cast<int>(factor_.rows(s).size());
        const int columns = factor_.column_count(s), below = rows - columns;
        T* x_j = row(factor_.first_column[at(s)]);
        blas::trsm_lower('R', 'T', active, columns, values(s), rows, x_j, width_);
        if (below == 0) return;
        below_.resize(at(active) * at(below));
        blas::gemm('N', 'T', active, below, columns, T(1), x_j, width_, values(s) + columns, rows, T(0), below_.data(),
                   active);
        const T* from = below_.data();
        for (int place : factor_.rows(s).subspan(at(columns))) {
            T* to = row(place);
            for (int c = 0; c < active; ++c) to[c] -= from[c];
            from += active;
        }
    }

    void backward(std::int32_t s) {
        const auto rows = static_cast<int>(factor_.rows(s).size());
        const int columns = factor_.column_count(s), below = rows - columns;
        T* x_j = row(factor_.first_column[at(s)]);
        if (below > 0) {
            below_.resize(at(width_) * at(below));
            T* to = below_.data();
            for (int place : factor_.rows(s).subspan(at(columns))) to = std::copy_n(row(place), width_, to);
            blas::gemm('N', 'N', width_, columns, below, T(-1), below_.data(), width_, values(s) + columns, rows, T(1),
                       x_j, width_);
        }
        blas::trsm_lower('R', 'N', width_, columns, values(s), rows, x_j, width_);
    }

    const ColumnSolver& solver_;
    Supernodes factor_;
    std::vector<std::size_t> begin_;  // [supernodes] first column of a needed one in x_
    std::vector<T> x_, below_, copy_;
    int width_ = 0;
};

ColumnSolver::ColumnSolver(const Supernodes& factor, std::span<const std::int32_t> node,
                           std::span<const std::int32_t> row)
    : factor_(factor),
      parent_(factor.parents()),
      owner_(factor.owners()),
      place_(factor.places()),
      node_(node.begin(), node.end()),
      row_(row.begin(), row.end()) {
    std::vector<std::int32_t> column(place_.size() / 3, -1), row_at(place_.size() / 3, -1);
    for (std::size_t c = 0; c < node_.size(); ++c) column[at(node_[c])] = static_cast<std::int32_t>(c);
    for (std::size_t k = 0; k < row_.size(); ++k) row_at[at(row_[k])] = static_cast<std::int32_t>(k);
    for (std::int32_t r : row_) column_of_row_.push_back(column[at(r)]);
    for (std::int32_t i : node_) row_of_column_.push_back(row_at[at(i)]);
    // Symmetry stands in for a block only where the transposed one is wanted too.
    if (std::count(row_of_column_.begin(), row_of_column_.end(), -1) > 0)
        column_of_row_.assign(column_of_row_.size(), -1);
    needed_.assign(parent_.size(), 0);
    always_.assign(parent_.size(), 0);
    for (std::size_t k = 0; k < row_.size(); ++k)
        for (int d = 0; d < 3; ++d) {
            const std::size_t s = at(owner_[at(place_[at(3 * row_[k] + d)])]);
            needed_[s] = 1;
            if (column_of_row_[k] < 0) always_[s] = 1;
        }
    for (std::int32_t i : node_)
        for (int d = 0; d < 3; ++d) needed_[at(owner_[at(place_[at(3 * i + d)])])] = 1;
    mark_ancestors(parent_, needed_);
    mark_ancestors(parent_, always_);
    group_ = make_groups(node);
    first_of_.resize(node_.size());
    for (Group& group : group_) {
        for (std::int32_t c : group.column) first_of_[at(c)] = group.first_supernode;
        flops_ += count(group);
    }
}

std::vector<ColumnSolver::Group> ColumnSolver::make_groups(std::span<const std::int32_t> node) const {
    std::vector<std::int32_t> order;
    for (std::size_t c = 0; c < node.size(); ++c) order.push_back(static_cast<std::int32_t>(c));
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
        return place_[at(3 * node[at(a)])] < place_[at(3 * node[at(b)])];
    });
    std::vector<Group> groups;
    for (std::size_t first = 0; first < order.size(); first += kGroup) {
        Group group;
        const auto begin = order.begin() + static_cast<std::ptrdiff_t>(first);
        group.column.assign(begin, begin + static_cast<std::ptrdiff_t>(std::min(kGroup, order.size() - first)));
        find_solves(group);
        groups.push_back(std::move(group));
    }
    return groups;
}

void ColumnSolver::find_solves(Group& group) const {
    std::vector<char> on_path(parent_.size(), 0);
    group.first_supernode = factor_.count();
    for (std::int32_t c : group.column)
        for (int d = 0; d < 3; ++d) {
            const std::int32_t s = owner_[at(place_[at(3 * node_[at(c)] + d)])];
            on_path[at(s)] = 1;
            group.first_supernode = std::min(group.first_supernode, s);
        }
    mark_ancestors(parent_, on_path);
    for (std::int32_t s = 0; s < factor_.count(); ++s)
        if (on_path[at(s)]) group.path.push_back(s);
    for (std::int32_t s = factor_.count() - 1; s >= 0; --s)
        if (always_[at(s)] || (needed_[at(s)] && s >= group.first_supernode)) group.back.push_back(s);
}

/// Right-hand sides whose load lies in or before supernode s; the group's nodes ascend.
int ColumnSolver::active(const Group& group, std::int32_t s) const {
    const std::int32_t end = factor_.first_column[at(s) + 1];
    const auto later = std::partition_point(group.column.begin(), group.column.end(), [&](std::int32_t c) {
        const std::int32_t* place = &place_[at(3 * node_[at(c)])];
        return std::min({place[0], place[1], place[2]}) < end;
    });
    return static_cast<int>(3 * (later - group.column.begin()));
}

double ColumnSolver::count(const Group& group) const {
    const auto flops = [&](std::int32_t s, double width) {
        const double columns = factor_.column_count(s), rows = static_cast<double>(factor_.rows(s).size());
        return width * columns * (columns + 2.0 * (rows - columns));
    };
    double sum = 0.0;
    for (std::int32_t s : group.path) sum += flops(s, active(group, s));
    for (std::int32_t s : group.back) sum += flops(s, 3.0 * static_cast<double>(group.column.size()));
    return sum;
}

template <typename T>
double ColumnSolver::bytes() const {
    double columns = 0.0, below = 0.0;
    for (std::int32_t s = 0; s < factor_.count(); ++s)
        if (needed_[at(s)]) {
            columns += factor_.column_count(s);
            below = std::max(below, static_cast<double>(factor_.rows(s).size()) - factor_.column_count(s));
        }
    const double copy = std::is_same_v<T, double> ? 0.0 : factor_.value_begin.back();
    return ((columns + below) * 3.0 * static_cast<double>(kGroup) + copy) * sizeof(T);
}

template <typename T>
void ColumnSolver::hand_out(const Group& group, const Workspace<T>& x, const Take& take) const {
    Eigen::Matrix3f block;
    for (std::size_t k = 0; k < row_.size(); ++k) {
        const std::int32_t* place = &place_[at(3 * row_[k])];
        const std::int32_t s = std::min({owner_[at(place[0])], owner_[at(place[1])], owner_[at(place[2])]});
        const bool is_column = column_of_row_[k] >= 0;
        if (is_column && s < group.first_supernode) continue;  // comes from an earlier group, transposed
        for (std::size_t c = 0; c < group.column.size(); ++c) {
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) block(a, b) = static_cast<float>(x.row(place[a])[3 * c + at(b)]);
            const std::int32_t column = group.column[c];
            take(at(column), k, block);
            // Does the row's own group come too late in the tree to compute this node's row?
            const std::int32_t other_row = row_of_column_[at(column)];
            if (!is_column || other_row < 0) continue;
            const std::int32_t* own = &place_[at(3 * node_[at(column)])];
            const std::int32_t own_s = std::min({owner_[at(own[0])], owner_[at(own[1])], owner_[at(own[2])]});
            if (own_s < first_of_[at(column_of_row_[k])]) take(at(column_of_row_[k]), at(other_row), block.transpose());
        }
    }
}

template <typename T>
void ColumnSolver::compute(Progress& progress, const Take& take) const {
    Workspace<T> x(*this);
    double done = 0.0;
    for (const Group& group : group_) {
        progress.done(done / flops_);
        x.solve(group);
        hand_out(group, x, take);
        done += count(group);
    }
}

template void ColumnSolver::compute<double>(Progress&, const Take&) const;
template void ColumnSolver::compute<float>(Progress&, const Take&) const;
template double ColumnSolver::bytes<double>() const;
template double ColumnSolver::bytes<float>() const;

}  // namespace haptable
