// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/mask_load.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/base/progress.hpp"
#include "host/base/workers.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

template <typename Key>
std::size_t place_of(const Key& key, const std::vector<Key>& ascending) {
    return static_cast<std::size_t>(std::lower_bound(ascending.begin(), ascending.end(), key) - ascending.begin());
}

void add(const NodeWeights& weights, double times, LoadShares& shares) {
    for (std::size_t k = 0; k < weights.node.size(); ++k) shares[weights.node[k]] += times * weights.weight[k];
}

}  // namespace

Masks masks_on(std::span<const Vector3d> position_m, std::span<const std::array<std::int32_t, 3>> patch,
               double radius_m) {
    Workers workers(1);
    Progress progress(true);
    return make_masks(position_m, patch, radius_m, workers, progress);
}

LoadShares mask_load(const Masks& masks, const std::array<std::int32_t, 3>& patch, const Vector3d& alpha) {
    LoadShares shares;
    for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t d = (c + 1) % 3;
        const auto [low, high] = std::minmax(patch[c], patch[d]);
        const double a = alpha[static_cast<Index>(c)], b = alpha[static_cast<Index>(d)];
        add(masks.vertex[place_of(patch[c], masks.vertex_id)], a * a, shares);
        add(masks.edge[place_of(std::array<std::int32_t, 2>{low, high}, masks.edge_id)], 2.0 * a * b, shares);
    }
    return shares;
}

std::pair<std::array<std::int32_t, 3>, Vector3d> locate(std::span<const Vector3d> position_m,
                                                        std::span<const std::array<std::int32_t, 3>> patch,
                                                        const Vector3d& x_m) {
    for (const auto& corner : patch) {
        const Vector3d& v = position_m[static_cast<std::size_t>(corner[0])];
        Eigen::Matrix<double, 3, 2> edges;
        edges << position_m[static_cast<std::size_t>(corner[1])] - v,
            position_m[static_cast<std::size_t>(corner[2])] - v;
        const Eigen::Vector2d beta = (edges.transpose() * edges).ldlt().solve(edges.transpose() * (x_m - v));
        const Vector3d alpha(1.0 - beta.sum(), beta[0], beta[1]);
        if (alpha.minCoeff() > -1e-9 && (v + edges * beta - x_m).norm() < 1e-6 * edges.norm()) return {corner, alpha};
    }
    throw Error("the bench presses a place that is on no patch");
}

}  // namespace haptable
