// SPDX-License-Identifier: GPL-2.0-or-later
// L_ij = (L^-1 E_i)^T S (L^-1 E_j)   or   L^T X_j = S L^-1 E_j at row i   (L with blocks: K^-1; alone: the factor)
#include "host/inverse/pairs.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "host/base/shared_progress.hpp"
#include "host/inverse/solve/blas.hpp"

namespace haptable {

namespace {

std::vector<std::int32_t> merge(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
    std::vector<std::int32_t> all;
    std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
    return all;
}

std::vector<std::int32_t> common(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
    std::vector<std::int32_t> both;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    return both;
}

/// Where the groups' forward solutions are held at a time: from the first group that needs one to its own turn.
template <typename Begin, typename End>
void for_each_life(std::size_t groups, const std::vector<std::vector<std::int32_t>>& partners, Begin begin, End end) {
    std::vector<char> held(groups, 0);
    for (std::size_t g = 0; g < groups; ++g) {
        const auto need = [&](std::size_t other) {
            if (!std::exchange(held[other], 1)) begin(other);
        };
        need(g);
        for (std::int32_t partner : partners[g]) need(at(partner));
        end(g);
    }
}

}  // namespace

CompliancePairs::CompliancePairs(const Supernodes& factor, std::span<const NodePair> wanted,
                                 std::optional<PairSolve> only)
    : factor_(factor), tree_(factor) {
    find_unique(wanted);
    std::vector<std::size_t> all(unique_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    plan_ = plan(all, only);
    flops_ = plan_.flops;
    if (only) return;
    // Would selected inversion of what lies in the pattern, and solves for the rest, be cheaper? Not where the rest
    // alone is not.
    std::vector<NodePair> pairs;
    for (const Unique& pair : unique_) pairs.push_back({pair.later, pair.earlier});
    const std::vector<char> inside = find_in_pattern(factor_, pairs);
    std::vector<NodePair> inside_pairs;
    std::vector<std::size_t> inverted, outside;
    for (std::size_t u = 0; u < pairs.size(); ++u) {
        (inside[u] ? inverted : outside).push_back(u);
        if (inside[u]) inside_pairs.push_back(pairs[u]);
    }
    if (inverted.empty()) return;
    Plan rest = plan(std::move(outside), {});
    if (rest.flops >= flops_) return;
    SelectedInversion inversion(factor_, inside_pairs);
    if (inversion.flops() + rest.flops >= flops_) return;
    flops_ = inversion.flops() + rest.flops;
    plan_ = std::move(rest);
    inverted_ = std::move(inverted);
    inversion_.emplace(std::move(inversion));
}

void CompliancePairs::find_unique(std::span<const NodePair> wanted) {
    struct Ask {
        std::int32_t earlier, later;                   // places in the tree
        std::size_t number;                            // of the wanted pair
        auto operator<=>(const Ask&) const = default;  // NOLINT(modernize-use-nullptr): it is none
    };
    std::vector<std::int32_t> place(tree_.place.size() / 3), node_at(tree_.place.size());
    for (std::size_t node = 0; node < place.size(); ++node) {
        place[node] = tree_.place_of(static_cast<std::int32_t>(node));
        node_at[at(place[node])] = static_cast<std::int32_t>(node);
    }
    std::vector<Ask> ask;  // by place in the tree: deterministic, and near
    for (const NodePair& pair : wanted) {
        const auto [earlier, later] = std::minmax(place[at(pair.row)], place[at(pair.column)]);
        ask.push_back({earlier, later, ask.size()});
    }
    std::sort(ask.begin(), ask.end());
    unique_of_.resize(wanted.size());
    transposed_.resize(wanted.size());
    for (std::size_t a = 0; a < ask.size(); ++a) {
        if (a == 0 || ask[a].earlier != ask[a - 1].earlier || ask[a].later != ask[a - 1].later)
            unique_.push_back({node_at[at(ask[a].earlier)], node_at[at(ask[a].later)]});
        unique_of_[ask[a].number] = unique_.size() - 1;
        transposed_[ask[a].number] = unique_.back().later != wanted[ask[a].number].row ? 1 : 0;
    }
}

CompliancePairs::Plan CompliancePairs::plan(std::vector<std::size_t> solved, std::optional<PairSolve> only) const {
    Plan plan;
    plan.solved = std::move(solved);
    if (plan.solved.empty()) return plan;
    make_groups(plan);
    find_partners(plan);
    find_paths(plan);
    choose(plan, only);
    return plan;
}

/// All nodes of the pairs, in the order of the tree, kGroup at a time.
void CompliancePairs::make_groups(Plan& plan) const {
    std::vector<char> asked(tree_.place.size() / 3, 0);
    for (std::size_t u : plan.solved) asked[at(unique_[u].earlier)] = asked[at(unique_[u].later)] = 1;
    std::vector<std::int32_t> nodes;
    for (std::size_t node = 0; node < asked.size(); ++node)
        if (asked[node] != 0) nodes.push_back(static_cast<std::int32_t>(node));
    const auto before = [&](std::int32_t a, std::int32_t b) { return tree_.place_of(a) < tree_.place_of(b); };
    std::sort(nodes.begin(), nodes.end(), before);
    plan.group_of.assign(tree_.place.size() / 3, -1);
    plan.column_of = plan.group_of;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (n % kGroup == 0) plan.group.emplace_back();
        plan.group_of[at(nodes[n])] = static_cast<std::int32_t>(n / kGroup);
        plan.column_of[at(nodes[n])] = static_cast<std::int32_t>(n % kGroup);
        plan.group.back().node.push_back(nodes[n]);
    }
}

void CompliancePairs::find_partners(Plan& plan) const {
    const auto partner = [&](std::size_t u) { return plan.group_of[at(unique_[u].later)]; };
    for (std::size_t u : plan.solved) plan.group[at(plan.group_of[at(unique_[u].earlier)])].pair.push_back(u);
    for (Group& group : plan.group) {
        std::stable_sort(group.pair.begin(), group.pair.end(),
                         [&](std::size_t a, std::size_t b) { return partner(a) < partner(b); });
        for (std::size_t p = 0; p < group.pair.size(); ++p)
            if (p == 0 || partner(group.pair[p]) != group.partner.back()) {
                group.partner.push_back(partner(group.pair[p]));
                group.pair_begin.push_back(p);
            }
        group.pair_begin.push_back(group.pair.size());
    }
}

void CompliancePairs::find_paths(Plan& plan) const {
    for (Group& group : plan.group) {
        std::vector<std::int32_t> later;
        for (std::size_t u : group.pair) later.push_back(unique_[u].later);
        group.path = tree_.path(group.node);
        group.back = tree_.path(later);
        group.all = merge(group.path, group.back);
    }
}

/// Right-hand sides whose load lies in or before supernode s; the group's nodes ascend.
int CompliancePairs::active(const Group& group, std::int32_t s) const {
    const std::int32_t end = factor_.first_column[at(s) + 1];
    const auto later = std::partition_point(group.node.begin(), group.node.end(),
                                            [&](std::int32_t node) { return tree_.place_of(node) < end; });
    return static_cast<int>(3 * (later - group.node.begin()));
}

double CompliancePairs::columns_of(std::span<const std::int32_t> supernodes) const {
    double columns = 0.0;
    for (std::int32_t s : supernodes) columns += factor_.column_count(s);
    return columns;
}

double CompliancePairs::forward_flops(const Group& group) const {
    double flops = 0.0;
    for (std::int32_t s : group.path) flops += active(group, s) * solve_flops(factor_, s);
    return flops;
}

/// Counts both ways and takes the cheaper one that fits.
void CompliancePairs::choose(Plan& plan, std::optional<PairSolve> only) const {
    double paths = 0.0, solves = 0.0, most_solve_bytes = 0.0, most_path_bytes = 0.0, held = 0.0;
    std::vector<std::vector<std::int32_t>> partners;
    const auto width = [](const Group& group) { return 3.0 * static_cast<double>(group.node.size()); };
    const auto bytes = [&](const Group& group, const std::vector<std::int32_t>& supernodes) {
        return width(group) * columns_of(supernodes) * sizeof(double);
    };
    for (const Group& group : plan.group) {
        const double forward = forward_flops(group);
        paths += forward;
        for (std::int32_t partner : group.partner) {
            const Group& other = plan.group[at(partner)];
            paths += 2.0 * width(group) * width(other) * columns_of(common(group.path, other.path));
        }
        partners.push_back(group.partner);
        if (group.pair.empty()) continue;
        solves += forward;
        for (std::int32_t s : group.back) solves += width(group) * solve_flops(factor_, s);
        most_solve_bytes = std::max(most_solve_bytes, bytes(group, group.all));
    }
    for_each_life(
        plan.group.size(), partners,
        [&](std::size_t g) {
            held += bytes(plan.group[g], plan.group[g].path);
            most_path_bytes = std::max(most_path_bytes, held);
        },
        [&](std::size_t g) { held -= bytes(plan.group[g], plan.group[g].path); });
    const bool by_paths = only ? *only == PairSolve::kPaths : paths < solves && most_path_bytes < kMostPathBytes;
    plan.way = by_paths ? PairSolve::kPaths : PairSolve::kSolves;
    plan.flops = by_paths ? paths : solves;
    plan.bytes = by_paths ? most_path_bytes : most_solve_bytes;
}

std::string CompliancePairs::method() const {
    std::string solves = plan_.way == PairSolve::kPaths ? "path solves" : "pruned solves";
    if (!inversion_) return solves;
    return plan_.solved.empty() ? "selected inversion" : "selected inversion and " + solves;
}

void CompliancePairs::forward(const Group& group, std::span<const std::int32_t> room, TreeSolver<double>& x) const {
    x.begin(room, static_cast<int>(3 * group.node.size()));
    for (std::size_t c = 0; c < group.node.size(); ++c)
        for (std::size_t d = 0; d < 3; ++d) x.row(tree_.place[3 * at(group.node[c]) + d])[3 * c + d] = 1.0;
    for (std::int32_t s : group.path) x.forward(s, active(group, s));
}

double CompliancePairs::bytes(int workers) const {
    const double solves = plan_.bytes * (plan_.way == PairSolve::kSolves ? workers : 1);
    if (!inversion_) return solves;
    return std::max(static_cast<double>(inversion_->stack_entries(workers)) * sizeof(double), solves);
}

void CompliancePairs::by_solves(Progress& progress, Workers& workers, std::vector<Eigen::Matrix3d>& block) const {
    std::vector<TreeSolver<double>> x;
    for (int worker = 0; worker < workers.count(); ++worker) x.emplace_back(factor_, tree_, factor_.value);
    SharedProgress share(progress, plan_.group.size());
    workers.for_each(plan_.group.size(), [&](std::size_t g, int worker) {
        share.begin_one();
        if (!plan_.group[g].pair.empty()) solve(plan_.group[g], x[static_cast<std::size_t>(worker)], block);
    });
}

/// The pairs of one group, by one pruned solve.
void CompliancePairs::solve(const Group& group, TreeSolver<double>& x, std::vector<Eigen::Matrix3d>& block) const {
    forward(group, group.all, x);
    for (auto s = group.back.rbegin(); s != group.back.rend(); ++s) x.backward(*s);
    for (std::size_t u : group.pair) {
        const std::size_t c = at(plan_.column_of[at(unique_[u].earlier)]);
        for (std::size_t a = 0; a < 3; ++a) {
            const double* row = x.row(tree_.place[3 * at(unique_[u].later) + a]) + 3 * c;
            for (std::size_t b = 0; b < 3; ++b)
                block[u](static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = row[b];
        }
    }
}

/// The pairs of group a with its partner of that number: products of their forward solutions, X and Y.
void CompliancePairs::multiply(const Group& a, const TreeSolver<double>& x, std::size_t partner,
                               const TreeSolver<double>& y, std::vector<Eigen::Matrix3d>& block) const {
    const Group& b = plan_.group[at(a.partner[partner])];
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(x.width(), y.width());
    for (std::int32_t s : common(a.path, b.path)) {
        const std::int32_t first = factor_.first_column[at(s)];
        const int columns = factor_.column_count(s), positive = factor_.positive_count(s);
        const auto add = [&](double sign, std::int32_t begin, int count) {
            blas::gemm('N', 'T', x.width(), y.width(), count, sign, x.row(begin), x.width(), y.row(begin), y.width(),
                       1.0, product.data(), x.width());
        };
        if (positive > 0) add(1.0, first, positive);
        if (positive < columns) add(-1.0, first + positive, columns - positive);
    }
    for (std::size_t p = a.pair_begin[partner]; p < a.pair_begin[partner + 1]; ++p) {
        const Unique& pair = unique_[a.pair[p]];
        block[a.pair[p]] = product
                               .block<3, 3>(Eigen::Index{3} * plan_.column_of[at(pair.earlier)],
                                            Eigen::Index{3} * plan_.column_of[at(pair.later)])
                               .transpose();
    }
}

/// Forward solutions that a group begins to need are found side by side, then its products are.
void CompliancePairs::by_paths(Progress& progress, Workers& workers, std::vector<Eigen::Matrix3d>& block) const {
    std::vector<std::vector<std::int32_t>> partners;
    for (const Group& group : plan_.group) partners.push_back(group.partner);
    std::vector<std::unique_ptr<TreeSolver<double>>> held(plan_.group.size());
    std::vector<std::size_t> begun;
    const auto end = [&](std::size_t g) {
        const Group& group = plan_.group[g];
        workers.for_each(begun.size(), [&](std::size_t i, int) {
            auto& x = held[begun[i]] = std::make_unique<TreeSolver<double>>(factor_, tree_, factor_.value);
            forward(plan_.group[begun[i]], plan_.group[begun[i]].path, *x);
        });
        begun.clear();
        workers.for_each(group.partner.size(),
                         [&](std::size_t p, int) { multiply(group, *held[g], p, *held[at(group.partner[p])], block); });
        held[g].reset();
        progress.done(static_cast<double>(g + 1) / static_cast<double>(plan_.group.size()));
    };
    for_each_life(
        plan_.group.size(), partners, [&](std::size_t g) { begun.push_back(g); }, end);
}

std::vector<Eigen::Matrix3d> CompliancePairs::compute(Progress& progress, Workers* workers) const {
    Workers alone(1);
    if (workers == nullptr) workers = &alone;
    std::vector<Eigen::Matrix3d> block(unique_.size());
    if (inversion_) {
        const std::vector<Eigen::Matrix3d> inverted = inversion_->compute<double>(progress, workers);
        for (std::size_t k = 0; k < inverted.size(); ++k) block[inverted_[k]] = inverted[k];
    }
    if (plan_.way == PairSolve::kPaths)
        by_paths(progress, *workers, block);
    else
        by_solves(progress, *workers, block);
    for (std::size_t u : plan_.solved)  // a solve rounds L_ii's two triangles each for itself
        if (unique_[u].earlier == unique_[u].later)
            block[u] = Eigen::Matrix3d(block[u].selfadjointView<Eigen::Lower>());
    std::vector<Eigen::Matrix3d> answer(unique_of_.size());
    for (std::size_t w = 0; w < answer.size(); ++w) {
        answer[w] = block[unique_of_[w]];
        if (transposed_[w]) answer[w].transposeInPlace();
    }
    return answer;
}

}  // namespace haptable
