// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/page/columns.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "host/base/error.hpp"
#include "host/tables/columns.hpp"

namespace haptable {

namespace {

constexpr int kHalfExponent = 15;  // binary16 ends below 2^16

/// The power of 2 in whose steps the largest number is just held.
float unit_for(float largest) {
    return largest > 0.0F ? std::ldexp(1.0F, std::ilogb(largest) - kHalfExponent + 1) : 1.0F;
}

}  // namespace

PageRows page_rows(const Tables& tables) {
    PageRows rows{tables.node_id.size(), tables.node_id};
    const std::set<std::int32_t> all(tables.row_id.begin(), tables.row_id.end());
    const std::set<std::int32_t> with_column(tables.node_id.begin(), tables.node_id.end());
    for (const std::int32_t node : tables.node_id)
        if (!all.contains(node)) throw Error("row_id.npy lacks a touchable node: make the tables again");
    for (const std::int32_t node : all)
        if (!with_column.contains(node)) rows.node.push_back(node);
    return rows;
}

std::vector<std::size_t> stored_rows(const Tables& tables, const PageRows& rows) {
    std::vector<std::size_t> place(tables.position.size(), 0), stored;
    for (std::size_t r = 0; r < tables.row_id.size(); ++r) place[static_cast<std::size_t>(tables.row_id[r])] = r;
    for (const std::int32_t node : rows.node) stored.push_back(place[static_cast<std::size_t>(node)]);
    return stored;
}

std::size_t packed_count(const PageRows& rows) {
    const std::size_t n = rows.columns;
    return 9 * (n * rows.node.size() - n * (n - (n > 0 ? 1 : 0)) / 2);
}

PageColumns pack_columns(const Tables& tables, const TablesFolder& folder, const PageRows& rows, Storage format) {
    const MappedColumns columns(tables, folder);
    const std::vector<std::size_t> row = stored_rows(tables, rows);
    const auto each = [&](std::size_t i, const std::function<void(float)>& take) {
        for (std::size_t r = i; r < row.size(); ++r)
            for (std::size_t k = 0; k < 9; ++k) take(columns.at(columns.block(i, row[r]) + k));
    };
    PageColumns packed{format, 1.0F, 0.0, {}};
    const bool half = format == Storage::kFloat16;
    float largest = 0.0F;
    for (std::size_t i = 0; half && i < rows.columns; ++i)
        each(i, [&](float value) { largest = std::max(largest, std::abs(value)); });
    if (half) packed.unit_m_per_n = unit_for(largest);
    packed.bytes.reserve(packed_count(rows) * (half ? sizeof(Half) : sizeof(float)));
    for (std::size_t i = 0; i < rows.columns; ++i) {
        double sum = 0.0, lost = 0.0;
        each(i, [&](float value) {
            const Half rounded = to_half(value / packed.unit_m_per_n);
            if (half)
                packed.bytes.append(reinterpret_cast<const char*>(&rounded), sizeof rounded);
            else
                packed.bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
            const double left = half ? static_cast<double>(value - packed.unit_m_per_n * to_float(rounded)) : 0.0;
            sum += static_cast<double>(value) * static_cast<double>(value);
            lost += left * left;
        });
        if (sum > 0.0) packed.error = std::max(packed.error, std::sqrt(lost / sum));
    }
    return packed;
}

}  // namespace haptable
