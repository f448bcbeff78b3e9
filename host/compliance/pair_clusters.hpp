// SPDX-License-Identifier: GPL-2.0-or-later
// A symmetric matrix of 3x3 blocks in clusters: near ones in full, far ones between bases that clusters share.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <set>
#include <vector>

#include "host/base/progress.hpp"
#include "host/tables/pair.hpp"

namespace haptable {

/// A over m places, [3 m, 3 m], asked for by rows of a few places: [3 k, 3 m].
struct PlaceMatrix {
    std::vector<Eigen::Vector3d> position_m;  ///< [m]
    std::function<Eigen::MatrixXd(const std::vector<std::size_t>&)> rows;
    /// Places (the smaller one first) of which a patch with a fixed corner loads both: points of it hardly differ.
    std::set<std::pair<std::size_t, std::size_t>> alike{};
};

/// The most precise form within so many bytes of PairClusters' tables but loads and places, which are left empty:
/// `order` is what place of A each of its places is. A cluster's basis are the largest eigenvectors of the sum over all
/// others of A_IJ A_IJ^T over its trace; a core is U_I^T A_IJ U_J in 8 bits. Of every pair of clusters all forms are
/// tried, and each gets the smallest that stays below the one bound that just fits. Bounded is
/// |A_ii^-1/2 E_ij A_jj^-1/2|_F over max(1/128, 1 - c_ij), c_ij that of A_ij over sqrt(3): where two
/// places hardly differ, as those that are alike, a force has more of an error. Without places where even `most_bound`
/// does not fit; `least_bytes` do for that.
PairClusters cluster_pairs(const PlaceMatrix& a, std::size_t most_bytes, double most_bound,
                           std::vector<std::size_t>& order, std::size_t& least_bytes, Progress& progress);

/// A_ij, i and j being its places.
Eigen::Matrix3d cluster_block(const PairClusters& clusters, std::size_t i, std::size_t j);

}  // namespace haptable
