// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/solve/frame_solver.hpp"

#include <algorithm>

namespace haptable {

FrameSolver::FrameSolver(const Supernodes& factor, const float* value, std::span<const std::int32_t> row)
    : factor_(factor),
      tree_(factor),
      x_(factor, tree_, value),
      row_(row.begin(), row.end()),
      back_(tree_.path(row)),
      displacement_(3 * row.size()) {}

std::span<const float> FrameSolver::displace(std::span<const Load> loads) {
    std::vector<std::int32_t> nodes, all;
    for (const Load& load : loads) nodes.push_back(load.node);
    const std::vector<std::int32_t> path = tree_.path(nodes);
    std::set_union(path.begin(), path.end(), back_.begin(), back_.end(), std::back_inserter(all));
    x_.begin(all, 1);
    for (const Load& load : loads)
        for (std::size_t c = 0; c < 3; ++c) *x_.row(tree_.place[3 * at(load.node) + c]) += load.force_n[c];
    for (std::int32_t s : path) x_.forward(s, 1);
    if (!loads.empty())
        for (auto s = back_.rbegin(); s != back_.rend(); ++s) x_.backward(*s);
    for (std::size_t k = 0; k < row_.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c) displacement_[3 * k + c] = *x_.row(tree_.place[3 * at(row_[k]) + c]);
    return displacement_;
}

}  // namespace haptable
