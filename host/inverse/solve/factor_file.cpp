// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/solve/factor_file.hpp"

#include <algorithm>

namespace haptable {

namespace fs = std::filesystem;

namespace {

std::vector<std::int32_t> positive_counts(const Supernodes& factor) {
    std::vector<std::int32_t> count;
    for (std::int32_t k = 0; k < factor.count(); ++k) count.push_back(factor.positive_count(k));
    return count;
}

}  // namespace

void write_factor(const Supernodes& factor, std::span<const std::int32_t> unknown_node, const fs::path& folder) {
    const auto write = [&](const char* name, std::span<const std::int32_t> values) {
        write_npy<std::int32_t>(folder / name, {values.size()}, values);
    };
    write(kFactorFiles[0], factor.first_column);
    write(kFactorFiles[1], factor.row_begin);
    write(kFactorFiles[2], factor.value_begin);
    write(kFactorFiles[3], factor.row);
    write(kFactorFiles[4], factor.permutation);
    write(kFactorFiles[5], unknown_node);
    write(kFactorFiles[6], positive_counts(factor));
    NpyWriter<float> writer(folder / kFactorFiles[7], {at(factor.value_begin.back())});
    std::vector<float> column;
    std::size_t written = 0;
    for (std::int32_t k = 0; k < factor.count(); ++k) {
        const std::size_t rows = factor.rows(k).size();
        for (std::size_t j = 0; j < at(factor.column_count(k)); ++j) {
            const double* l = factor.values(k) + j * rows;
            column.assign(j, 0.0F);  // above the diagonal there is nothing
            column.insert(column.end(), l + j, l + rows);
            writer.append(column);
            written += rows;
        }
        column.assign(at(factor.value_begin[at(k) + 1]) - written, 0.0F);
        writer.append(column);
        written += column.size();
    }
    writer.close();
}

double factor_file_bytes(const Supernodes& s) {
    return static_cast<double>(s.value_begin.back()) * sizeof(float) +
           static_cast<double>(s.row.size() + 4 * s.first_column.size() + s.permutation.size()) * sizeof(std::int32_t);
}

FactorFile::FactorFile(const TablesFolder& folder)
    : first_column_(folder.file(kFactorFiles[0])),
      row_begin_(folder.file(kFactorFiles[1])),
      value_begin_(folder.file(kFactorFiles[2])),
      row_(folder.file(kFactorFiles[3])),
      permutation_(folder.file(kFactorFiles[4])),
      unknown_node_(folder.file(kFactorFiles[5])),
      positive_(folder.file(kFactorFiles[6])),
      value_(folder.file(kFactorFiles[7])) {
    check(folder);
}

Supernodes FactorFile::supernodes() const {
    return {first_column_.values(),
            row_begin_.values(),
            value_begin_.values(),
            row_.values(),
            permutation_.values(),
            positive_.values(),
            nullptr};
}

/// Damaged indices must be an error here, not a read beyond an array later.
void FactorFile::check(const TablesFolder& folder) const {
    const auto n = static_cast<std::int32_t>(permutation_.values().size());
    const auto require = [&](bool ok, const char* file) {
        if (!ok) folder.fail(file, "does not fit the factor's other files");
    };
    const auto ascends = [](std::span<const std::int32_t> list, std::size_t last) {
        return list.size() > 1 && list.front() == 0 && std::is_sorted(list.begin(), list.end()) &&
               static_cast<std::size_t>(list.back()) == last;
    };
    const auto below = [&](std::span<const std::int32_t> list, std::int32_t end) {
        return std::all_of(list.begin(), list.end(), [&](std::int32_t i) { return i >= 0 && i < end; });
    };
    const Supernodes s = supernodes();
    require(ascends(s.first_column, at(n)), kFactorFiles[0]);
    require(s.row_begin.size() == s.first_column.size() && ascends(s.row_begin, s.row.size()), kFactorFiles[1]);
    require(s.value_begin.size() == s.first_column.size() && ascends(s.value_begin, value_.values().size()),
            kFactorFiles[2]);
    require(below(s.row, n), kFactorFiles[3]);
    require(below(s.permutation, n), kFactorFiles[4]);
    require(3 * unknown_node_.values().size() <= s.permutation.size(), kFactorFiles[5]);
    require(s.positive.size() + 1 == s.first_column.size(), kFactorFiles[6]);
    std::size_t positive = 0;  // columns: as many as there are displacements
    for (std::int32_t k = 0; k < s.count(); ++k) {
        const std::size_t rows = s.rows(k).size(), columns = at(s.column_count(k));
        require(columns > 0 && rows >= columns, kFactorFiles[1]);
        require(at(s.value_begin[at(k) + 1] - s.value_begin[at(k)]) >= rows * columns, kFactorFiles[2]);
        require(s.positive[at(k)] >= 0 && at(s.positive[at(k)]) <= columns, kFactorFiles[6]);
        positive += at(s.positive[at(k)]);
    }
    require(positive == 3 * unknown_node_.values().size(), kFactorFiles[6]);
}

}  // namespace haptable
