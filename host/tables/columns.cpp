// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/columns.hpp"

#include <fmt/format.h>

namespace haptable {

MappedColumns::MappedColumns(const Tables& tables, const TablesFolder& folder) : rows_(tables.row_id.size()) {
    constexpr const char* kFile = "columns.npy";
    if (tables.half_columns) {
        half_.emplace(folder.file(kFile));
        unit_ = static_cast<float>(tables.column_unit_m_per_n);
    } else {
        single_.emplace(folder.file(kFile));
    }
    const std::vector<std::size_t> expected{tables.node_id.size(), rows_, 3, 3};
    if ((half_ ? half_->shape() : single_->shape()) != expected)
        folder.fail(kFile, fmt::format("does not have the {} columns of {} rows that node_id.npy and row_id.npy name",
                                       expected[0], expected[1]));
}

}  // namespace haptable
