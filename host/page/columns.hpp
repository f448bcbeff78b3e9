// SPDX-License-Identifier: GPL-2.0-or-later
// The columns of equation 8 as a page holds them: half of L, as it is symmetric, and binary16 where float32 is too
// much.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/tables/tables.hpp"

namespace haptable {

/// Rows stand in the order of the columns, and after them those that have no column, ascending.
struct PageRows {
    std::size_t columns = 0;         ///< n
    std::vector<std::int32_t> node;  ///< [r] mesh node of each row; the first n are tables.node_id
};

/// Throws Error where a column has no row, which no tables of ours have.
PageRows page_rows(const Tables& tables);

/// Where each of the page's rows stands among tables.row_id.
std::vector<std::size_t> stored_rows(const Tables& tables, const PageRows& rows);

/// Numbers of the packed half: 9 for each of n r - n (n - 1) / 2 blocks.
std::size_t packed_count(const PageRows& rows);

struct PageColumns {
    Storage format = Storage::kFloat32;  ///< or kFloat16
    float unit_m_per_n = 1.0F;           ///< of float16: a power of 2
    double error = 0.0;                  ///< ||stored - column|| / ||column||, of the worst column
    std::string bytes;                   ///< of column i the blocks [r - i, 3, 3] of rows i and on
};

/// Reads columns.npy of `folder`. before: tables.has_columns.
PageColumns pack_columns(const Tables& tables, const TablesFolder& folder, const PageRows& rows, Storage format);

}  // namespace haptable
