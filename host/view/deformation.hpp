// SPDX-License-Identifier: GPL-2.0-or-later
// u_r = sum over the loaded nodes i of L_ri F_i   (equation 8)
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "codegen/loads.hpp"
#include "host/inverse/solve/factor_file.hpp"
#include "host/inverse/solve/frame_solver.hpp"
#include "host/tables/columns.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// Equation 8 over the rows of columns.npy, in float32; where the scene keeps the factor instead, by one solve a call.
/// The file is read once for its hash, then mapped: of a table that is larger than the memory only the columns that are
/// touched stay there.
///
/// A column is copied the first time its node is loaded, into one of kSlots slots, in the order that the vector units
/// want: [blocks, 3, 16], so that one load brings 16 coefficients of one force component. As stored, [r, 3, 3], they
/// are three floats apart, and the product takes 2.5 times as long. A whole copy of the table would be as fast but
/// doubles a table that can have gigabytes.
class Deformation {
public:
    /// Maps the folder's columns.npy or the factor's files. Throws Error when the scene has neither or when they do not
    /// fit the tables.
    Deformation(const Tables& tables, const TablesFolder& folder);

    std::size_t rows() const { return rows_; }

    /// The displacements [r,3] in metres under `loads`, in the order of row_id.npy; valid until the next call. A node
    /// without a column is a fixed one: the force on it moves nothing. With columns no heap. For one thread.
    std::span<const float> displace(std::span<const NodalForce> loads);

private:
    static constexpr std::size_t kSlots = 64;  ///< loaded nodes that stay rearranged
    static constexpr std::size_t kGroup = 3;   ///< nodes of one sweep over the rows: a patch has three

    /// Panels of the nodes of one sweep.
    using Group = std::array<const float*, kGroup>;

    const float* panel(std::int32_t column, const Group& in_use) noexcept;
    float* slot(std::size_t index) const noexcept;
    void fill(std::int32_t column, float* panel) const noexcept;

    void open_factor(const Tables& tables, const TablesFolder& folder);
    std::span<const float> multiply(std::span<const NodalForce> loads) noexcept;
    std::span<const float> solve(std::span<const NodalForce> loads);

    std::optional<MappedColumns> columns_;
    std::optional<FactorFile> factor_;  // instead of columns
    std::optional<FrameSolver> solver_;
    std::vector<std::int32_t> unknown_of_;  ///< [N] unknown node of a mesh node, or -1: with the factor
    std::size_t rows_;
    std::size_t blocks_;                     ///< of 16 displacement components
    std::vector<std::int32_t> column_of_;    ///< [N] column of a mesh node, or -1
    std::vector<std::int32_t> slot_of_;      ///< [n] slot of a column, or -1
    std::array<std::int32_t, kSlots> held_;  ///< the column in each slot, or -1
    std::size_t next_slot_ = 0;              ///< the oldest one: overwritten next, unless in use

    struct Free {
        void operator()(float* memory) const;
    };
    std::unique_ptr<float[], Free> panels_;        ///< [slots, blocks, 3, 16]
    std::unique_ptr<float[], Free> displacement_;  ///< [blocks, 16], of which 3 r are used
};

}  // namespace haptable
