// SPDX-License-Identifier: GPL-2.0-or-later
// The pattern of a supernodal factor L of M = L S L^T, S = +-1 on its diagonal.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/base/index.hpp"

namespace haptable {

/// The factor as CHOLMOD stores it. A supernode is a run of columns of L with the same rows below; it is one dense
/// matrix, column-major, with a row for each of its `rows()`: first its own columns (the lower triangle counts), then
/// the rows below. Supernodes are numbered in postorder: children before parents. A view: the Factor must live on.
struct Supernodes {
    std::span<const int> first_column;  ///< [s + 1]
    std::span<const int> row_begin;     ///< [s + 1]
    std::span<const int> value_begin;   ///< [s + 1]
    std::span<const int> row;           ///< [row_begin[s]] ascending within a supernode
    std::span<const int> permutation;   ///< [n] row of M that became row p of L
    std::span<const int> positive;      ///< [s] columns with S = 1, which stand first; empty: all, and M = L L^T
    const double* value = nullptr;      ///< null before the factorisation

    std::int32_t count() const { return static_cast<std::int32_t>(first_column.size()) - 1; }
    int column_count(std::int32_t s) const { return first_column[at(s) + 1] - first_column[at(s)]; }
    int positive_count(std::int32_t s) const { return positive.empty() ? column_count(s) : positive[at(s)]; }
    std::span<const int> rows(std::int32_t s) const {
        return row.subspan(at(row_begin[at(s)]), at(row_begin[at(s) + 1] - row_begin[at(s)]));
    }
    const double* values(std::int32_t s) const { return value + value_begin[at(s)]; }
    /// [n] row of L that a row of M became.
    std::vector<std::int32_t> places() const;
    /// [n] supernode that holds a column of L.
    std::vector<std::int32_t> owners() const;
    /// [s] supernode that holds the first row below, or -1.
    std::vector<std::int32_t> parents() const;
};

}  // namespace haptable
