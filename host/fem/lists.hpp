// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace haptable {

/// Lists of numbers, one after another in one array.
class Lists {
public:
    std::size_t size() const { return begin_.size() - 1; }
    std::span<const std::int32_t> operator[](std::size_t i) const {
        return std::span(item_).subspan(begin_[i], begin_[i + 1] - begin_[i]);
    }
    std::size_t items() const { return item_.size(); }
    void append(std::span<const std::int32_t> list) {
        item_.insert(item_.end(), list.begin(), list.end());
        begin_.push_back(item_.size());
    }

    /// For every number below `count` the lists that hold it, ascending. Numbers below 0 are in none.
    Lists holders(std::size_t count) const {
        Lists lists;
        lists.begin_.assign(count + 1, 0);
        for (std::int32_t k : item_)
            if (k >= 0) ++lists.begin_[static_cast<std::size_t>(k) + 1];
        for (std::size_t k = 0; k < count; ++k) lists.begin_[k + 1] += lists.begin_[k];
        lists.item_.resize(lists.begin_.back());
        std::vector<std::size_t> next = lists.begin_;
        for (std::size_t i = 0; i < size(); ++i)
            for (std::int32_t k : (*this)[i])
                if (k >= 0) lists.item_[next[static_cast<std::size_t>(k)]++] = static_cast<std::int32_t>(i);
        return lists;
    }

    /// For every number below holders.size() the numbers of all lists that hold it, ascending, each once.
    Lists neighbours(const Lists& holders) const {
        Lists lists;
        std::vector<std::int32_t> near;
        for (std::size_t k = 0; k < holders.size(); ++k) {
            near.clear();
            for (std::int32_t i : holders[k]) {
                const auto list = (*this)[static_cast<std::size_t>(i)];
                near.insert(near.end(), list.begin(), list.end());
            }
            std::sort(near.begin(), near.end());
            near.erase(std::unique(near.begin(), near.end()), near.end());
            lists.append(std::span(near).subspan(near.empty() || near.front() >= 0 ? 0 : 1));
        }
        return lists;
    }

private:
    std::vector<std::size_t> begin_{0};  // [size() + 1]
    std::vector<std::int32_t> item_;
};

}  // namespace haptable
