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
        for (const auto& [node, controls] : under_) node_.push_back(node);
    }

    const std::vector<std::int32_t>& nodes() const { return node_; }  ///< unknowns under any mask, ascending

    /// x = L[:, node of the list], three columns: adds what this column gives to every product.
    void take(std::size_t n, const Eigen::Ref<const Eigen::MatrixXd>& x) {
        for (const auto& [k, weight] : under_.at(node_[n]))
            for (const auto& [j, sum] : partners_[k]) {
                Matrix3d block = Matrix3d::Zero();
                for (const auto& [row, w] : control_[j]) block += w * x.middleRows<3>(Eigen::Index{3} * row);
                *sum += weight * block;
            }
    }

    /// The symmetric part of M_JK.
    Matrix3d at(std::size_t j, std::size_t k) const {
        const Matrix3d& m = product_.at(key(j, k));
        return 0.5 * (m + m.transpose());
    }

private:
    static Pair key(std::size_t j, std::size_t k) { return {std::min(j, k), std::max(j, k)}; }
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
    std::vector<std::vector<std::pair<std::int32_t, double>>> control_;          // unknown, weight
    std::map<std::int32_t, std::vector<std::pair<std::size_t, double>>> under_;  // unknown -> controls, weights
    std::map<Pair, Matrix3d> product_;
    std::vector<std::vector<Partner>> partners_;
    std::vector<std::int32_t> node_;
};

}  // namespace

MaskCompliance compute_mask_compliance(const LinearSolver& solver, const Eigen::SparseMatrix<double>& k,
                                       const Masks& masks, std::span<const Patch> patch,
                                       std::span<const std::int32_t> unknown, Progress& progress) {
    Products m(masks, patch, unknown);
    MaskCompliance c;
    c.largest_residual =
        solve_columns(solver, k, m.nodes(), progress, [&](std::size_t first, const Eigen::MatrixXd& x) {
            for (Eigen::Index column = 0; column < x.cols(); column += 3)
                m.take(first + static_cast<std::size_t>(column / 3), x.middleCols<3>(column));
        });
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
