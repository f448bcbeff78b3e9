// SPDX-License-Identifier: GPL-2.0-or-later
// How far two tables of the same body lie apart.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/tables/npy.hpp"

namespace haptable::test {

inline double number(double x) { return x; }
inline double number(Half x) { return double(to_float(x)); }

/// Largest difference of two files' entries, as a share of the largest entry.
template <typename T>
double difference(const std::filesystem::path& a, const std::filesystem::path& b) {
    const MappedNpy<T> one(a), other(b);
    EXPECT_EQ(one.shape(), other.shape());
    double largest = 0.0, most = 0.0;
    for (std::size_t e = 0; e < std::min(one.values().size(), other.values().size()); ++e) {
        largest = std::max(largest, std::abs(number(one.values()[e]) - number(other.values()[e])));
        most = std::max(most, std::abs(number(one.values()[e])));
    }
    return largest / most;
}

}  // namespace haptable::test
