// SPDX-License-Identifier: GPL-2.0-or-later
// C = sum_JK binom(2,J) binom(2,K) alpha^(J+K) M_JK,   M_JK = sum_ab B_J(a) B_K(b) L_ab,   B: the masks' control
// weights
#include "host/precompute/point_compliance.hpp"

#include <algorithm>
#include <map>

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Edge = std::array<std::int32_t, 2>;
using Patch = std::array<std::int32_t, 3>;
using Pair = std::array<std::size_t, 2>;  // of control masks, lower first

std::size_t place_in(const auto& list, const auto& key) {
    return static_cast<std::size_t>(std::lower_bound(list.begin(), list.end(), key) - list.begin());
}

/// Numbers of a patch's control masks: its vertices, then the edges opposite to them; edges come after all vertices.
std::array<std::size_t, 6> controls_of(const Masks& masks, const Patch& corner) {
    std::array<std::size_t, 6> controls{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto [low, high] = std::minmax(corner[(c + 1) % 3], corner[(c + 2) % 3]);
        controls[c] = place_in(masks.vertex_id, corner[c]);
        controls[3 + c] = masks.vertex_id.size() + place_in(masks.edge_id, Edge{low, high});
    }
    return controls;
}

/// M_JK for the pairs of controls that meet in a patch.
class Products {
public:
    Products(const Masks& masks, std::span<const Patch> patch, std::span<const std::int32_t> unknown) {
        for (const auto* list : {&masks.vertex, &masks.edge})
            for (const NodeWeights& weights : *list) add_control(weights, unknown);
        for (const Patch& corner : patch) {
            const auto controls = controls_of(masks, corner);
            for (std::size_t j = 0; j < 6; ++j)
                for (std::size_t k = 0; k <= j; ++k)
                    product_.try_emplace(key(controls[j], controls[k]), Matrix3d::Zero());
        }
        partners_.resize(control_.size());
        for (auto& [pair, m] : product_) partners_[pair[1]].push_back({pair[0], &m});
    }

    /// Pairs whose L_ij the products need, each once, lower node first, ascending.
    std::vector<NodePair> pairs() const {
        std::vector<NodePair> pairs;
        for (const auto& [node, controls] : under_)
            for (std::int32_t row : rows_of(controls)) pairs.push_back({std::min(row, node), std::max(row, node)});
        std::sort(pairs.begin(), pairs.end(), before);
        const auto same = [](const NodePair& a, const NodePair& b) { return !before(a, b) && !before(b, a); };
        pairs.erase(std::unique(pairs.begin(), pairs.end(), same), pairs.end());
        return pairs;
    }

    /// Adds what each node's column of L gives to every product; l_ij: blocks of pairs().
    void take(std::span<const Matrix3d> l_ij) {
        const std::vector<NodePair> pair = pairs();
        std::map<std::int32_t, Matrix3d> column;  // of one node, at the rows that meet it
        for (const auto& [node, controls] : under_) {
            column.clear();
            for (std::int32_t row : rows_of(controls)) {
                const NodePair wanted{std::min(row, node), std::max(row, node)};
                const auto found = std::lower_bound(pair.begin(), pair.end(), wanted, before);
                const Matrix3d& block = l_ij[static_cast<std::size_t>(found - pair.begin())];
                column[row] = row <= node ? block : Matrix3d(block.transpose());
            }
            for (const auto& [k, weight] : controls)
                for (const auto& [j, sum] : partners_[k])
                    for (const auto& [row, w] : control_[j]) *sum += weight * w * column.at(row);
        }
    }

    /// The symmetric part of M_JK.
    Matrix3d at(std::size_t j, std::size_t k) const {
        const Matrix3d& m = product_.at(key(j, k));
        return 0.5 * (m + m.transpose());
    }

private:
    static Pair key(std::size_t j, std::size_t k) { return {std::min(j, k), std::max(j, k)}; }
    static bool before(const NodePair& a, const NodePair& b) {
        return std::pair(a.row, a.column) < std::pair(b.row, b.column);
    }
    using Weighted = std::vector<std::pair<std::size_t, double>>;  // controls, weights
    /// The nodes under any control that meets one of these, ascending.
    std::vector<std::int32_t> rows_of(const Weighted& controls) const {
        std::vector<std::size_t> met;
        for (const auto& [k, weight] : controls)
            for (const Partner& partner : partners_[k]) met.push_back(partner.control);
        std::sort(met.begin(), met.end());
        met.erase(std::unique(met.begin(), met.end()), met.end());
        std::vector<std::int32_t> rows;
        for (std::size_t j : met)
            for (const auto& [row, weight] : control_[j]) rows.push_back(row);
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        return rows;
    }
    void add_control(const NodeWeights& weights, std::span<const std::int32_t> unknown) {
        std::vector<std::pair<std::int32_t, double>> rows;
        for (std::size_t i = 0; i < weights.node.size(); ++i) {
            const std::int32_t row = unknown[static_cast<std::size_t>(weights.node[i])];
            if (row < 0) continue;  // a fixed node does not move
            rows.emplace_back(row, weights.weight[i]);
            under_[row].emplace_back(control_.size(), weights.weight[i]);
        }
        control_.push_back(std::move(rows));
    }

    struct Partner {
        std::size_t control;
        Matrix3d* sum;
    };
    std::vector<std::vector<std::pair<std::int32_t, double>>> control_;  // unknown, weight
    std::map<std::int32_t, Weighted> under_;                             // unknown -> controls, weights
    std::map<Pair, Matrix3d> product_;
    std::vector<std::vector<Partner>> partners_;
};

}  // namespace

std::vector<NodePair> mask_pairs(const Masks& masks, std::span<const Patch> patch,
                                 std::span<const std::int32_t> unknown) {
    return Products(masks, patch, unknown).pairs();
}

MaskCompliance compute_mask_compliance(const Masks& masks, std::span<const Patch> patch,
                                       std::span<const std::int32_t> unknown, std::span<const Matrix3d> l_ij) {
    Products m(masks, patch, unknown);
    m.take(l_ij);
    MaskCompliance c;
    for (std::size_t v = 0; v < masks.vertex_id.size(); ++v) c.vertex.push_back(m.at(v, v));
    for (std::size_t i = 0; i < masks.edge_id.size(); ++i) {
        const std::size_t v = place_in(masks.vertex_id, masks.edge_id[i][0]);
        const std::size_t w = place_in(masks.vertex_id, masks.edge_id[i][1]);
        const std::size_t e = masks.vertex_id.size() + i;
        c.edge.push_back({m.at(v, e), (2.0 * m.at(v, w) + 4.0 * m.at(e, e)) / 6.0, m.at(w, e)});
    }
    for (const Patch& corner : patch) {
        const auto n = controls_of(masks, corner);
        std::array<Matrix3d, 3> inside;
        for (std::size_t a = 0; a < 3; ++a)
            inside[a] = (m.at(n[a], n[3 + a]) + 2.0 * m.at(n[3 + (a + 1) % 3], n[3 + (a + 2) % 3])) / 3.0;
        c.patch.push_back(inside);
    }
    return c;
}

}  // namespace haptable
