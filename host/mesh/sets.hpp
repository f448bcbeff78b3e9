// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace haptable {

/// Disjoint sets of 0..n-1 with path halving; the least member stands for its set.
class Sets {
public:
    explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
    std::size_t find(std::size_t a) {
        while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
        return a;
    }
    void join(std::size_t a, std::size_t b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }
    /// [n] sets numbered in the order of their least members.
    std::vector<std::size_t> numbers() {
        std::vector<std::size_t> number(parent_.size());
        std::size_t count = 0;
        for (std::size_t a = 0; a < parent_.size(); ++a) {
            const std::size_t root = find(a);
            number[a] = root == a ? count++ : number[root];
        }
        return number;
    }

private:
    std::vector<std::size_t> parent_;
};

}  // namespace haptable
