// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/earlier_tables.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "host/base/index.hpp"
#include "host/precompute/facts.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

namespace {

/// Place of a value in an ascending list, or -1.
std::int32_t place_in(std::span<const std::int32_t> list, std::int32_t value) {
    const auto found = std::lower_bound(list.begin(), list.end(), value);
    return found == list.end() || *found != value ? -1 : static_cast<std::int32_t>(found - list.begin());
}

std::vector<std::int32_t> places_in(std::span<const std::int32_t> list, std::span<const std::int32_t> values) {
    std::vector<std::int32_t> places;
    for (std::int32_t value : values) places.push_back(place_in(list, value));
    return places;
}

/// Copies a 3x3 block, or its transpose.
void copy_block(const ColumnReader& from, std::size_t from_block, ColumnFile& to, std::size_t to_block,
                bool transpose) {
    for (std::size_t e = 0; e < 9; ++e)
        to.set(9 * to_block + (transpose ? 3 * (e % 3) + e / 3 : e), from.at(9 * from_block + e));
}

}  // namespace

EarlierTables::EarlierTables(const std::filesystem::path& folder, const Identity& wanted,
                             std::span<const std::int32_t> rows, const std::string& column_format) {
    const std::optional<EarlierFacts> earlier = read_earlier(folder, wanted);
    if (!earlier) return;
    folder_ = earlier->folder;
    summary_ = earlier->inverse;
    const Tables tables = read_tables(*folder_);
    node_id_ = tables.node_id;
    row_id_ = tables.row_id;
    stiffness_ = tables.stiffness;
    has_blocks_ = earlier->tolerance == wanted.tolerance && stiffness_.size() == node_id_.size();
    has_factor_ = tables.has_factor;
    const bool fits = summary_.columns.format == column_format || summary_.columns.format == "float32";
    has_columns_ = tables.has_columns && fits && earlier->column_tolerance == wanted.column_tolerance &&
                   std::includes(row_id_.begin(), row_id_.end(), rows.begin(), rows.end());
}

std::vector<std::int32_t> EarlierTables::places_of(std::span<const std::int32_t> nodes) const {
    return places_in(node_id_, nodes);
}

Eigen::Matrix3d EarlierTables::stiffness(std::int32_t place) const {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(stiffness_[at(place)].data());
}

std::vector<Eigen::Matrix3d> EarlierTables::compliance() const {
    std::vector<Eigen::Matrix3d> l_ii;
    for (std::size_t i = 0; i < stiffness_.size(); ++i)
        l_ii.emplace_back(stiffness(static_cast<std::int32_t>(i)).llt().solve(Eigen::Matrix3d::Identity()));
    return l_ii;
}

void EarlierTables::copy_columns(std::span<const std::int32_t> node, std::span<const std::int32_t> place,
                                 std::span<const std::int32_t> rows, ColumnFile& to) const {
    const ColumnReader from(folder_->file("columns.npy"),
                            {summary_.columns.format == "float16", summary_.columns.unit_m_per_n});
    const std::vector<std::int32_t> earlier_row = places_in(row_id_, rows);
    const std::vector<std::int32_t> row_of_node = places_in(rows, node);             // in the new table
    const std::vector<std::int32_t> earlier_row_of_node = places_in(row_id_, node);  // -1: no such row
    for (std::size_t j = 0; j < node.size(); ++j) {
        if (place[j] < 0) continue;
        const std::size_t column = at(place[j]) * row_id_.size();
        for (std::size_t k = 0; k < rows.size(); ++k)
            copy_block(from, column + at(earlier_row[k]), to, j * rows.size() + k, false);
        if (row_of_node[j] < 0) continue;
        for (std::size_t i = 0; i < node.size(); ++i)
            if (place[i] < 0 && earlier_row_of_node[i] >= 0)
                copy_block(from, column + at(earlier_row_of_node[i]), to, i * rows.size() + at(row_of_node[j]), true);
    }
}

}  // namespace haptable
