// SPDX-License-Identifier: GPL-2.0-or-later
// columns.npy, mapped: what a picture needs of L, float32 or float16.
#pragma once

#include <optional>
#include <span>

#include "host/tables/npy.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// L_ri, m/N, of n columns (node_id.npy) and r rows (row_id.npy): [n, r, 3, 3].
class MappedColumns {
public:
    /// before: tables.has_columns. Throws Error that names the file where it does not fit the tables.
    MappedColumns(const Tables& tables, const TablesFolder& folder);

    std::size_t rows() const { return rows_; }
    /// Where the [3, 3] block of a column and a row begins.
    std::size_t block(std::size_t column, std::size_t row) const { return 9 * (column * rows_ + row); }
    /// An entry, m/N.
    float at(std::size_t i) const { return half_ ? unit_ * to_float(half_->values()[i]) : single_->values()[i]; }

    /// How they are stored; in units of unit_m_per_n() where it is half.
    bool is_half() const { return half_.has_value(); }
    std::span<const float> single() const { return single_->values(); }
    std::span<const Half> half() const { return half_->values(); }
    float unit_m_per_n() const { return unit_; }

private:
    std::size_t rows_;
    float unit_ = 1.0F;
    std::optional<MappedNpy<float>> single_;
    std::optional<MappedNpy<Half>> half_;
};

}  // namespace haptable
