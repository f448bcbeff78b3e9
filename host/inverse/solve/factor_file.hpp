// SPDX-License-Identifier: GPL-2.0-or-later
// A factor on the disk: what a viewer solves with where the columns would be too large.
#pragma once

#include <array>
#include <filesystem>

#include "host/inverse/solve/supernodes.hpp"
#include "host/tables/folder.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

/// Names of the files; docs/SPEC.md says what they hold.
inline constexpr std::array<const char*, 8> kFactorFiles{
    "factor_first_column.npy", "factor_row_begin.npy",    "factor_value_begin.npy", "factor_row.npy",
    "factor_permutation.npy",  "factor_unknown_node.npy", "factor_positive.npy",    "factor_value.npy"};

/// Writes them into the folder, the values as float.
///   unknown_node  [n] mesh node of every unknown node
void write_factor(const Supernodes& factor, std::span<const std::int32_t> unknown_node,
                  const std::filesystem::path& folder);

/// Bytes of the files.
double factor_file_bytes(const Supernodes& factor);

/// The files, mapped: of a factor larger than the memory only what is used is read.
class FactorFile {
public:
    /// Throws Error that names the file: missing, damaged, or not fitting the others.
    explicit FactorFile(const TablesFolder& folder);

    Supernodes supernodes() const;  ///< without `value`
    std::span<const float> value() const { return value_.values(); }
    std::span<const std::int32_t> unknown_node() const { return unknown_node_.values(); }

private:
    void check(const TablesFolder& folder) const;

    MappedNpy<std::int32_t> first_column_, row_begin_, value_begin_, row_, permutation_, unknown_node_, positive_;
    MappedNpy<float> value_;
};

}  // namespace haptable
