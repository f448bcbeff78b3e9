// SPDX-License-Identifier: GPL-2.0-or-later
// What an earlier run left in the folder that still holds: nothing of it is computed twice.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/compliance/column_store.hpp"
#include "host/precompute/summary.hpp"

namespace haptable {

/// Blocks hold for the same body, program and tolerance; columns for the same column tolerance. They do not depend on
/// what may be touched, nor on limits and contact options. Float16 columns do not stand in for float32 ones.
class EarlierTables {
public:
    EarlierTables() = default;  ///< nothing is there
    /// wanted: of this run. rows: [r] mesh nodes whose displacement columns.npy shall give; column_format: as in
    /// [tables].
    EarlierTables(const std::filesystem::path& folder, const Identity& wanted, std::span<const std::int32_t> rows,
                  const std::string& column_format);

    bool has_blocks() const { return has_blocks_; }
    bool has_columns() const { return has_columns_; }
    bool has_factor() const { return has_factor_; }  ///< for a viewer that solves
    const InverseSummary& summary() const { return summary_; }

    /// [nodes] places of mesh nodes in the earlier table, or -1.
    std::vector<std::int32_t> places_of(std::span<const std::int32_t> nodes) const;
    /// S_i of an earlier place, N/m.
    Eigen::Matrix3d stiffness(std::int32_t place) const;
    std::vector<Eigen::Matrix3d> compliance() const;  ///< L_ii of all earlier nodes, m/N, from their S_i

    /// Puts into `to` the columns of the nodes that were there, and of the others the rows of these (L_ij = L_ji^T).
    ///   node   [n] mesh nodes of the new table
    ///   place  [n] their earlier places, or -1
    ///   rows   [r] mesh nodes of its rows, as given to the constructor
    void copy_columns(std::span<const std::int32_t> node, std::span<const std::int32_t> place,
                      std::span<const std::int32_t> rows, ColumnFile& to) const;

private:
    std::optional<TablesFolder> folder_;  ///< where it holds tables of the same body
    InverseSummary summary_;
    bool has_blocks_ = false, has_columns_ = false, has_factor_ = false;
    std::vector<std::int32_t> node_id_, row_id_;
    std::vector<std::array<double, 9>> stiffness_;
};

}  // namespace haptable
