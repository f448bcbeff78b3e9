// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/solve/supernodes.hpp"

#include <algorithm>

namespace haptable {

std::vector<std::int32_t> Supernodes::places() const {
    std::vector<std::int32_t> place(permutation.size());
    for (std::size_t p = 0; p < place.size(); ++p) place[at(permutation[p])] = static_cast<std::int32_t>(p);
    return place;
}

std::vector<std::int32_t> Supernodes::owners() const {
    std::vector<std::int32_t> owner(permutation.size());
    for (std::int32_t s = 0; s < count(); ++s) std::fill_n(owner.begin() + first_column[at(s)], column_count(s), s);
    return owner;
}

std::vector<std::int32_t> Supernodes::parents() const {
    const std::vector<std::int32_t> owner = owners();
    std::vector<std::int32_t> parent(at(count()), -1);
    for (std::int32_t s = 0; s < count(); ++s)
        if (rows(s).size() > at(column_count(s))) parent[at(s)] = owner[at(rows(s)[at(column_count(s))])];
    return parent;
}

}  // namespace haptable
