// SPDX-License-Identifier: GPL-2.0-or-later
// L^-1 E up the tree along the paths of a group's nodes, L^-T of it down again to the wanted rows
#include "host/inverse/column_solver.hpp"

#include <algorithm>
#include <mutex>
#include <type_traits>

namespace haptable {

namespace {

/// Marks the supernodes and all their ancestors.
void mark_ancestors(const std::vector<std::int32_t>& parent, std::vector<char>& marked) {
    for (std::size_t s = 0; s < parent.size(); ++s)  // children come before their parents
        if (marked[s] && parent[s] >= 0) marked[at(parent[s])] = 1;
}

/// The factor's values in precision T: a view, or a copy that is held in `copy`.
template <typename T>
const T* values_in(const Supernodes& factor, std::vector<T>& copy) {
    if constexpr (std::is_same_v<T, double>) {
        return factor.value;
    } else {
        copy.assign(factor.value, factor.value + factor.value_begin.back());
        return copy.data();
    }
}

}  // namespace

ColumnSolver::ColumnSolver(const Supernodes& factor, std::span<const std::int32_t> node,
                           std::span<const std::int32_t> row, Precision precision, Workers* workers)
    : precision_(precision),
      workers_(workers),
      factor_(factor),
      tree_(factor),
      node_(node.begin(), node.end()),
      row_(row.begin(), row.end()) {
    const std::size_t unknowns = tree_.place.size() / 3;
    std::vector<std::int32_t> column(unknowns, -1), row_at(unknowns, -1);
    for (std::size_t c = 0; c < node_.size(); ++c) column[at(node_[c])] = static_cast<std::int32_t>(c);
    for (std::size_t k = 0; k < row_.size(); ++k) row_at[at(row_[k])] = static_cast<std::int32_t>(k);
    for (std::int32_t r : row_) column_of_row_.push_back(column[at(r)]);
    for (std::int32_t i : node_) row_of_column_.push_back(row_at[at(i)]);
    // Symmetry stands in for a block only where the transposed one is wanted too.
    if (std::count(row_of_column_.begin(), row_of_column_.end(), -1) > 0)
        column_of_row_.assign(column_of_row_.size(), -1);
    needed_.assign(tree_.parent.size(), 0);
    always_ = needed_;
    for (std::size_t k = 0; k < row_.size(); ++k)
        for (int d = 0; d < 3; ++d) {
            const std::size_t s = at(tree_.owner[at(tree_.place[at(3 * row_[k] + d)])]);
            needed_[s] = 1;
            if (column_of_row_[k] < 0) always_[s] = 1;
        }
    for (std::int32_t i : node_)
        for (int d = 0; d < 3; ++d) needed_[at(tree_.owner[at(tree_.place[at(3 * i + d)])])] = 1;
    mark_ancestors(tree_.parent, needed_);
    mark_ancestors(tree_.parent, always_);
    group_ = make_groups(node);
    first_of_.resize(node_.size());
    for (Group& group : group_) {
        for (std::int32_t c : group.column) first_of_[at(c)] = group.first_supernode;
        flops_ += group.flops = count(group);
    }
}

std::vector<ColumnSolver::Group> ColumnSolver::make_groups(std::span<const std::int32_t> node) const {
    std::vector<std::int32_t> order;
    for (std::size_t c = 0; c < node.size(); ++c) order.push_back(static_cast<std::int32_t>(c));
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
        return tree_.place[at(3 * node[at(a)])] < tree_.place[at(3 * node[at(b)])];
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
    std::vector<std::int32_t> nodes;
    for (std::int32_t c : group.column) nodes.push_back(node_[at(c)]);
    group.path = tree_.path(nodes);
    group.first_supernode = group.path.front();
    for (std::int32_t s = 0; s < factor_.count(); ++s)
        if (always_[at(s)] || (needed_[at(s)] && s >= group.first_supernode)) group.back.push_back(s);
    std::set_union(group.path.begin(), group.path.end(), group.back.begin(), group.back.end(),
                   std::back_inserter(group.all));
}

/// Right-hand sides whose load lies in or before supernode s; the group's nodes ascend.
int ColumnSolver::active(const Group& group, std::int32_t s) const {
    const std::int32_t end = factor_.first_column[at(s) + 1];
    const auto later = std::partition_point(group.column.begin(), group.column.end(),
                                            [&](std::int32_t c) { return tree_.place_of(node_[at(c)]) < end; });
    return static_cast<int>(3 * (later - group.column.begin()));
}

double ColumnSolver::count(const Group& group) const {
    double sum = 0.0;
    for (std::int32_t s : group.path) sum += active(group, s) * solve_flops(factor_, s);
    for (std::int32_t s : group.back) sum += 3.0 * static_cast<double>(group.column.size()) * solve_flops(factor_, s);
    return sum;
}

double ColumnSolver::bytes(int workers) const {
    double most = 0.0;
    for (const Group& group : group_) {
        double columns = 0.0, below = 0.0;
        for (std::int32_t s : group.all) {
            columns += factor_.column_count(s);
            below = std::max(below, static_cast<double>(factor_.rows(s).size()) - factor_.column_count(s));
        }
        most = std::max(most, (columns + below) * 3.0 * static_cast<double>(group.column.size()));
    }
    if (precision_ == Precision::kDouble) return most * workers * sizeof(double);
    return (most * workers + factor_.value_begin.back()) * sizeof(float);
}

template <typename T>
void ColumnSolver::solve(const Group& group, TreeSolver<T>& x) const {
    x.begin(group.all, static_cast<int>(3 * group.column.size()));
    for (std::size_t c = 0; c < group.column.size(); ++c)
        for (std::size_t d = 0; d < 3; ++d)
            x.row(tree_.place[3 * at(node_[at(group.column[c])]) + d])[3 * c + d] = T(1);
    for (std::int32_t s : group.path) x.forward(s, active(group, s));
    for (auto s = group.back.rbegin(); s != group.back.rend(); ++s) x.backward(*s);
}

template <typename Each>
void ColumnSolver::visit_blocks(const Group& group, Each visit) const {
    // A few rows at a time for every column: the file is written in stretches, and X stays in the cache.
    constexpr std::size_t kRows = 64;
    std::vector<std::size_t> rows;
    for (std::size_t k = 0; k < row_.size(); ++k)  // others come from an earlier group, transposed
        if (column_of_row_[k] < 0 || tree_.first_of(row_[k]) >= group.first_supernode) rows.push_back(k);
    for (std::size_t first = 0; first < rows.size(); first += kRows)
        for (std::size_t c = 0; c < group.column.size(); ++c) {
            const std::int32_t other_row = row_of_column_[at(group.column[c])];
            const std::int32_t own = tree_.first_of(node_[at(group.column[c])]);
            for (std::size_t k = first; k < std::min(rows.size(), first + kRows); ++k) {
                // Does the row's own group come too late in the tree to compute this node's row?
                const std::int32_t column = column_of_row_[rows[k]];
                visit(rows[k], c, column >= 0 && other_row >= 0 && own < first_of_[at(column)]);
            }
        }
}

void ColumnSolver::for_each_block(std::size_t group, const Visit& visit) const {
    visit_blocks(group_[group], [&](std::size_t k, std::size_t c, bool given) {
        const std::int32_t column = group_[group].column[c];
        visit(at(column), k);
        if (given) visit(at(column_of_row_[k]), at(row_of_column_[at(column)]));
    });
}

template <typename T>
void ColumnSolver::hand_out(const Group& group, const TreeSolver<T>& x, const Sink& sink) const {
    Eigen::Matrix3f block;
    visit_blocks(group, [&](std::size_t k, std::size_t c, bool given) {
        for (std::size_t a = 0; a < 3; ++a) {
            const T* row = x.row(tree_.place[3 * at(row_[k]) + a]) + 3 * c;
            for (std::size_t b = 0; b < 3; ++b)
                block(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = static_cast<float>(row[b]);
        }
        const std::int32_t column = group.column[c];
        sink.take(at(column), k, block);
        if (given) sink.take(at(column_of_row_[k]), at(row_of_column_[at(column)]), block.transpose());
    });
}

template <typename T>
ColumnFacts ColumnSolver::compute_in(Progress& progress, const Sink& sink) const {
    Workers alone(1);
    Workers& workers = workers_ != nullptr ? *workers_ : alone;
    ColumnFacts facts{precision_, flops_, 0.0, 0};
    std::vector<std::size_t> left;
    double begun = flops_;  // operations of what is done already
    for (std::size_t g = 0; g < group_.size(); ++g)
        if (sink.have && sink.have(g)) {
            facts.resumed += group_[g].column.size();
        } else {
            left.push_back(g);
            begun -= group_[g].flops;
        }
    if (left.empty()) return facts;
    std::vector<T> copy;
    const T* value = values_in<T>(factor_, copy);
    std::vector<TreeSolver<T>> x;
    for (int worker = 0; worker < workers.count(); ++worker) x.emplace_back(factor_, tree_, value);
    std::mutex mutex;
    workers.for_each(left.size(), [&](std::size_t index, int worker) {
        const Group& group = group_[left[index]];
        {
            const std::lock_guard lock(mutex);
            progress.done((begun + facts.flops_done) / flops_);
        }
        solve(group, x[at(worker)]);
        hand_out(group, x[at(worker)], sink);
        const std::lock_guard lock(mutex);
        facts.flops_done += group.flops;
        if (sink.done) sink.done(left[index]);
    });
    return facts;
}

ColumnFacts ColumnSolver::compute(Progress& progress, const Sink& sink) const {
    return precision_ == Precision::kDouble ? compute_in<double>(progress, sink) : compute_in<float>(progress, sink);
}

}  // namespace haptable
