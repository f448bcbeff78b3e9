// SPDX-License-Identifier: GPL-2.0-or-later
// What every way to blocks of L = K^-1 is compared with: the dense inverse, and how far roundings may lead from it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "host/inverse/inverse.hpp"
#include "tests/conditioning.hpp"
#include "tests/dense.hpp"

namespace haptable::test {

/// first, first + step, ... below count.
inline std::vector<std::int32_t> nodes_to(std::int32_t count, std::int32_t step = 1, std::int32_t first = 0) {
    std::vector<std::int32_t> list;
    for (std::int32_t i = first; i < count; i += step) list.push_back(i);
    return list;
}

/// Takes a second for a thousand unknowns: tests that share K share it.
struct DenseReference {
    explicit DenseReference(Stiffness stiffness) : k(std::move(stiffness)) {}

    Stiffness k;
    Eigen::MatrixXd l = dense::inverse_spd(Eigen::MatrixXd(assembled(k)));
    Bound bound = inverse_bound(k);  ///< of error()

    Eigen::Matrix3d block(std::int32_t i, std::int32_t j) const {
        return l.block<3, 3>(Eigen::Index{3} * i, Eigen::Index{3} * j);
    }
    /// ||given - L_ij|| / sqrt(||L_ii|| ||L_jj||)
    double error(const Eigen::Matrix3d& given, std::int32_t i, std::int32_t j) const {
        return (given - block(i, j)).norm() / std::sqrt(block(i, i).norm() * block(j, j).norm());
    }
    /// The largest of all; infinite where the numbers of blocks and pairs differ.
    double error(std::span<const Eigen::Matrix3d> given, std::span<const NodePair> pairs) const {
        if (given.size() != pairs.size()) return HUGE_VAL;
        double largest = 0.0;
        for (std::size_t p = 0; p < pairs.size(); ++p)
            largest = std::max(largest, error(given[p], pairs[p].row, pairs[p].column));
        return largest;
    }
};

}  // namespace haptable::test
