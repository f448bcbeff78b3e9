// SPDX-License-Identifier: GPL-2.0-or-later
// C = sum_JK binom(2,J) binom(2,K) alpha^(J+K) M_JK,   M_JK = sum_ab B_J(a) B_K(b) L_ab,   B: the masks' control
// weights
//
// Only the symmetric part of C counts, and so of L_ab: six numbers, the same for L_ba. Neighbouring masks lie over
// nearly the same nodes: the blocks of all of them are gathered once, and Y = L B is one dense product.
#include "host/compliance/point_compliance.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "host/base/index.hpp"
#include "host/base/shared_progress.hpp"
#include "host/inverse/solve/blas.hpp"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Six = std::array<double, 6>;  // xx yy zz xy yz zx

constexpr std::size_t kMasksPerProduct = 24;  // fewer gather the same blocks more often, more multiply more zeros

Six symmetric_part(const Matrix3d& m) {
    return {m(0, 0), m(1, 1), m(2, 2), 0.5 * (m(0, 1) + m(1, 0)), 0.5 * (m(1, 2) + m(2, 1)), 0.5 * (m(0, 2) + m(2, 0))};
}

Matrix3d whole(const Six& s) {
    Matrix3d m;
    m << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
    return m;
}

/// Lists of different length, one after the other.
template <typename T>
struct Lists {
    std::vector<std::size_t> begin{0};
    std::vector<T> item;

    std::size_t size() const { return begin.size() - 1; }
    std::span<const T> operator[](std::size_t i) const {
        return std::span(item).subspan(begin[i], begin[i + 1] - begin[i]);
    }
    void end_list() { begin.push_back(item.size()); }
};

/// Which of `count` numbers were named since the last clear().
class Marks {
public:
    explicit Marks(std::size_t count) : round_(count, 0) {}
    void clear() { ++now_; }
    bool has(std::int32_t i) const { return round_[at(i)] == now_; }
    /// True where it is new.
    bool add(std::int32_t i) { return std::exchange(round_[at(i)], now_) != now_; }

private:
    std::vector<std::uint32_t> round_;
    std::uint32_t now_ = 1;
};

/// The masks' nodes as unknowns.
struct Weight {
    std::int32_t node;
    double weight;
};

Lists<Weight> weights_of(const Masks& masks, std::span<const std::int32_t> unknown) {
    Lists<Weight> lists;
    for (std::size_t k = 0; k < masks.vertex.size() + masks.edge.size(); ++k) {
        const NodeWeights& mask = masks.weights(k);
        for (std::size_t i = 0; i < mask.node.size(); ++i)
            if (const std::int32_t u = unknown[at(mask.node[i])]; u >= 0) lists.item.push_back({u, mask.weight[i]});
        lists.end_list();
    }
    return lists;
}

/// The controls that meet each control in a patch, itself among them, ascending.
Lists<std::size_t> meeting(const Masks& masks) {
    std::vector<std::array<std::size_t, 2>> pair;
    for (const auto& controls : masks.control)
        for (std::size_t j : controls)
            for (std::size_t k : controls) pair.push_back({j, k});
    std::sort(pair.begin(), pair.end());
    pair.erase(std::unique(pair.begin(), pair.end()), pair.end());
    Lists<std::size_t> lists;
    for (std::size_t p = 0; p < pair.size(); ++p) {
        if (p > 0 && pair[p][0] != pair[p - 1][0]) lists.end_list();
        lists.item.push_back(pair[p][1]);
    }
    lists.end_list();
    return lists;
}

std::size_t count_of(std::span<const std::int32_t> unknown) {
    return static_cast<std::size_t>(std::count_if(unknown.begin(), unknown.end(), [](auto u) { return u >= 0; }));
}

// ---- the pairs ------------------------------------------------------------------------------------------------------

/// The nodes under each patch's controls, ascending.
std::vector<std::vector<std::int32_t>> nodes_under(const Masks& masks, const Lists<Weight>& weights,
                                                   std::vector<Marks>& marks, Workers& workers) {
    std::vector<std::vector<std::int32_t>> under(masks.control.size());
    workers.for_each(under.size(), [&](std::size_t p, int worker) {
        Marks& seen = marks[at(worker)];
        seen.clear();
        for (std::size_t k : masks.control[p])
            for (const Weight& w : weights[k])
                if (seen.add(w.node)) under[p].push_back(w.node);
        std::sort(under[p].begin(), under[p].end());
    });
    return under;
}

/// The patches whose controls lie over each node.
Lists<std::size_t> patches_over(const std::vector<std::vector<std::int32_t>>& under, std::size_t nodes) {
    std::vector<std::vector<std::size_t>> over(nodes);
    for (std::size_t p = 0; p < under.size(); ++p)
        for (std::int32_t node : under[p]) over[at(node)].push_back(p);
    Lists<std::size_t> lists;
    for (const auto& patches : over) {
        lists.item.insert(lists.item.end(), patches.begin(), patches.end());
        lists.end_list();
    }
    return lists;
}

// ---- the products ---------------------------------------------------------------------------------------------------

/// The symmetric parts of the blocks, and which of them are a node's.
struct SymmetricBlocks {
    struct Entry {
        std::int32_t node;
        std::uint32_t block;
    };
    std::vector<Six> block;  // [pairs]
    Lists<Entry> of_node;    // ascending

    SymmetricBlocks(std::span<const NodePair> pair, std::span<const Matrix3d> l_ij, std::size_t nodes) {
        std::vector<std::size_t>& begin = of_node.begin;
        begin.assign(nodes + 1, 0);
        for (const Matrix3d& l : l_ij) block.push_back(symmetric_part(l));
        for (const NodePair& p : pair) {
            ++begin[at(p.row) + 1];
            if (p.row != p.column) ++begin[at(p.column) + 1];
        }
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        of_node.item.resize(begin.back());
        std::vector<std::size_t> end(begin.begin(), begin.end() - 1);
        // Pairs ascend with the lower node first, so a node gets its lower partners before its higher ones.
        for (std::size_t p = 0; p < pair.size(); ++p) {
            const auto number = static_cast<std::uint32_t>(p);
            of_node.item[end[at(pair[p].row)]++] = {pair[p].column, number};
            if (pair[p].row != pair[p].column) of_node.item[end[at(pair[p].column)]++] = {pair[p].row, number};
        }
    }
};

/// M_JK of all pairs of controls that meet, J <= K.
struct Products {
    Lists<std::size_t> partner;  // [K] J, ascending
    std::vector<Six> m;          // as partner.item

    Matrix3d at(std::size_t j, std::size_t k) const {
        const auto& list = partner[std::max(j, k)];
        const auto found = std::lower_bound(list.begin(), list.end(), std::min(j, k));
        return whole(m[partner.begin[std::max(j, k)] + static_cast<std::size_t>(found - list.begin())]);
    }
};

/// The products of one group of controls, which lie side by side; what a worker keeps is its room.
class GroupProduct {
public:
    GroupProduct(const Lists<Weight>& weights, const SymmetricBlocks& l, std::size_t nodes)
        : weights_(weights), l_(l), row_of_(nodes, -1), column_of_(nodes, -1) {}

    /// Returns the multiplications and additions of the dense product.
    double compute(std::span<const std::size_t> group, Products& products) {
        number_nodes(group, products);
        gather();
        weigh(group);
        y_.assign(6 * row_.size() * group.size(), 0.0);  // and so it stays where all nodes of the group are fixed
        const int rows = static_cast<int>(6 * row_.size()), columns = static_cast<int>(column_.size());
        if (rows > 0 && columns > 0)
            blas::gemm('N', 'N', rows, static_cast<int>(group.size()), columns, 1.0, block_.data(), rows, b_.data(),
                       columns, 0.0, y_.data(), rows);
        for (std::size_t g = 0; g < group.size(); ++g) finish(group[g], &y_[6 * row_.size() * g], products);
        for (std::int32_t node : row_) row_of_[at(node)] = -1;
        for (std::int32_t node : column_) column_of_[at(node)] = -1;
        return 2.0 * static_cast<double>(block_.size() * group.size());
    }

private:
    static void number(std::span<const Weight> weights, std::vector<std::int32_t>& place,
                       std::vector<std::int32_t>& list) {
        for (const Weight& w : weights)
            if (place[at(w.node)] < 0) {
                place[at(w.node)] = static_cast<std::int32_t>(list.size());
                list.push_back(w.node);
            }
    }
    /// Columns: the nodes under the group's controls; rows: those under their partners.
    void number_nodes(std::span<const std::size_t> group, const Products& products) {
        row_.clear();
        column_.clear();
        for (std::size_t k : group) {
            number(weights_[k], column_of_, column_);
            for (std::size_t j : products.partner[k]) number(weights_[j], row_of_, row_);
        }
    }
    /// The blocks between them; zero where no mask joins two nodes: no product that is used has it.
    void gather() {
        block_.assign(6 * row_.size() * column_.size(), 0.0);
        for (std::size_t c = 0; c < column_.size(); ++c)
            for (const auto& [node, block] : l_.of_node[at(column_[c])])
                if (const std::int32_t r = row_of_[at(node)]; r >= 0)
                    std::copy_n(l_.block[block].begin(), 6, &block_[6 * (row_.size() * c + at(r))]);
    }
    void weigh(std::span<const std::size_t> group) {
        b_.assign(column_.size() * group.size(), 0.0);
        for (std::size_t g = 0; g < group.size(); ++g)
            for (const Weight& w : weights_[group[g]]) b_[column_.size() * g + at(column_of_[at(w.node)])] = w.weight;
    }
    /// M_jk = B_j^T Y_k.
    void finish(std::size_t k, const double* y, Products& products) const {
        for (std::size_t p = products.partner.begin[k]; p < products.partner.begin[k + 1]; ++p) {
            Six sum{};
            for (const Weight& w : weights_[products.partner.item[p]])
                for (std::size_t i = 0; i < 6; ++i) sum[i] += w.weight * y[6 * at(row_of_[at(w.node)]) + i];
            products.m[p] = sum;
        }
    }

    const Lists<Weight>& weights_;
    const SymmetricBlocks& l_;
    std::vector<std::int32_t> row_of_, column_of_;  // [nodes] or -1
    std::vector<std::int32_t> row_, column_;
    std::vector<double> block_, b_, y_;
};

/// Where the controls' places are: vertices, and the middles of edges.
std::vector<Eigen::Vector3d> places_of(const Masks& masks, std::span<const Eigen::Vector3d> position_m) {
    std::vector<Eigen::Vector3d> place;
    for (std::int32_t v : masks.vertex_id) place.push_back(position_m[at(v)]);
    for (const auto& [a, b] : masks.edge_id) place.push_back(0.5 * (position_m[at(a)] + position_m[at(b)]));
    return place;
}

/// Halves along the longest side of their box until a group is small enough.
void halve(std::span<std::size_t> controls, std::span<const Eigen::Vector3d> place, Lists<std::size_t>& groups) {
    if (controls.size() <= kMasksPerProduct) {
        groups.item.insert(groups.item.end(), controls.begin(), controls.end());
        groups.end_list();
        return;
    }
    Eigen::Vector3d low = place[controls[0]], high = low;
    for (std::size_t k : controls) {
        low = low.cwiseMin(place[k]);
        high = high.cwiseMax(place[k]);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t half = controls.size() / 2;
    std::nth_element(
        controls.begin(), controls.begin() + static_cast<std::ptrdiff_t>(half), controls.end(),
        [&](std::size_t a, std::size_t b) { return std::pair(place[a][axis], a) < std::pair(place[b][axis], b); });
    halve(controls.first(half), place, groups);
    halve(controls.subspan(half), place, groups);
}

Products products_of(const Masks& masks) {
    const Lists<std::size_t> all = meeting(masks);
    Products products;
    for (std::size_t k = 0; k < all.size(); ++k) {
        for (std::size_t j : all[k])
            if (j <= k) products.partner.item.push_back(j);
        products.partner.end_list();
    }
    products.m.resize(products.partner.item.size());
    return products;
}

/// The polynomials' blocks from the products of the controls.
MaskCompliance blocks_of(const Masks& masks, const Products& m) {
    MaskCompliance c;
    const std::size_t vertices = masks.vertex.size();
    for (std::size_t v = 0; v < vertices; ++v) c.vertex.push_back(m.at(v, v));
    c.edge.resize(masks.edge.size());
    for (const auto& n : masks.control)
        for (std::size_t a = 0; a < 3; ++a) {
            const auto [v, w] = std::minmax(n[(a + 1) % 3], n[(a + 2) % 3]);  // as their nodes: these ascend
            const std::size_t e = n[3 + a];
            c.edge[e - vertices] = {m.at(v, e), (2.0 * m.at(v, w) + 4.0 * m.at(e, e)) / 6.0, m.at(w, e)};
        }
    for (const auto& n : masks.control) {
        std::array<Matrix3d, 3> inside;
        for (std::size_t a = 0; a < 3; ++a)
            inside[a] = (m.at(n[a], n[3 + a]) + 2.0 * m.at(n[3 + (a + 1) % 3], n[3 + (a + 2) % 3])) / 3.0;
        c.patch.push_back(inside);
    }
    return c;
}

}  // namespace

std::vector<NodePair> mask_pairs(const Masks& masks, std::span<const std::int32_t> unknown, Workers& workers) {
    const std::size_t nodes = count_of(unknown);
    const Lists<Weight> weights = weights_of(masks, unknown);
    std::vector<Marks> marks(at(workers.count()), Marks(nodes));
    const auto under = nodes_under(masks, weights, marks, workers);
    const Lists<std::size_t> over = patches_over(under, nodes);
    std::vector<std::vector<std::int32_t>> columns(nodes);
    workers.for_each(nodes, [&](std::size_t row, int worker) {
        Marks& seen = marks[at(worker)];
        seen.clear();
        for (std::size_t p : over[row])
            for (auto node = under[p].rbegin(); *node > static_cast<std::int32_t>(row); ++node)
                if (seen.add(*node)) columns[row].push_back(*node);
        if (over.begin[row + 1] > over.begin[row]) columns[row].push_back(static_cast<std::int32_t>(row));
        std::sort(columns[row].begin(), columns[row].end());
    });
    std::vector<NodePair> pairs;
    for (std::size_t row = 0; row < nodes; ++row)
        for (std::int32_t column : columns[row]) pairs.push_back({static_cast<std::int32_t>(row), column});
    return pairs;
}

MaskCompliance compute_mask_compliance(const Masks& masks, std::span<const Eigen::Vector3d> position_m,
                                       std::span<const std::int32_t> unknown, std::span<const NodePair> pair,
                                       std::span<const Matrix3d> l_ij, Workers& workers, Progress& progress) {
    const std::size_t nodes = count_of(unknown);
    const Lists<Weight> weights = weights_of(masks, unknown);
    const SymmetricBlocks l(pair, l_ij, nodes);
    Products products = products_of(masks);
    std::vector<std::size_t> controls(weights.size());
    std::iota(controls.begin(), controls.end(), std::size_t{0});
    Lists<std::size_t> groups;
    halve(controls, places_of(masks, position_m), groups);
    std::vector<GroupProduct> room(at(workers.count()), GroupProduct(weights, l, nodes));
    SharedProgress share(progress, groups.size());
    std::vector<double> flops(groups.size());
    workers.for_each(groups.size(), [&](std::size_t g, int worker) {
        share.begin_one();
        flops[g] = room[at(worker)].compute(groups[g], products);
    });
    MaskCompliance compliance = blocks_of(masks, products);
    compliance.flops = std::accumulate(flops.begin(), flops.end(), 0.0);
    return compliance;
}

}  // namespace haptable
