// SPDX-License-Identifier: GPL-2.0-or-later
// A scene's folder in memory: checked, then const.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "codegen/model.hpp"
#include "codegen/pair.hpp"
#include "codegen/vibration.hpp"
#include "firmware/haptable.h"
#include "firmware/haptable_body.h"
#include "host/tables/npy.hpp"
#include "host/tables/tables.hpp"
#include "host/tables/vibration.hpp"
#include "host/view/loads.hpp"

namespace haptable {

class LoadedObject {
public:
    /// Throws Error that names the file: missing, or not what haptable-precompute wrote. wanted: tables_hash, or 0.
    LoadedObject(const std::filesystem::path& folder, std::uint64_t wanted);
    LoadedObject(const LoadedObject&) = delete;
    LoadedObject& operator=(const LoadedObject&) = delete;

    const Tables& tables() const { return tables_; }
    const haptable_model& model() const { return model_; }
    /// Of a scene with two fingers; else null.
    const haptable_pair_model* pair() const { return pair_ ? &pair_model_ : nullptr; }
    /// Where nothing holds it; else null.
    const haptable_body* body() const { return body_ ? &*body_ : nullptr; }
    /// Of a body that rings, on model(); else null.
    const haptable_modes* modes() const { return vibration_ ? &modes_ : nullptr; }
    std::size_t rows() const { return tables_.has_columns ? tables_.row_id.size() : 0; }
    /// Mesh node of a vertex of the model; -1: HAPTABLE_NONE.
    std::int32_t node_of(std::uint16_t vertex) const { return vertex == HAPTABLE_NONE ? -1 : servo_.node[vertex]; }

    /// u_r = sum L_ri F_i (equation 8) of the rows numbered by `row`, or, where it is empty, of all. displacement_m:
    /// [rows asked for, 3]. Throws Error without columns and for a row that there is not.
    void deform(const std::vector<NodalForce>& on_patch, std::span<const std::uint32_t> row,
                std::span<float> displacement_m) const;

    /// u_r += sum phi_kr q_k. swung: [modes]; else as deform().
    void swing(std::span<const float> swung, std::span<const std::uint32_t> row, std::span<float> displacement_m) const;

private:
    void require_rows(std::span<const std::uint32_t> row) const;
    void open_columns(const std::filesystem::path& folder);
    template <typename Number>
    void add_column(std::span<const Number> column, const NodalForce& load, std::span<const std::uint32_t> row,
                    std::span<float> displacement_m) const;

    Tables tables_;
    ServoModel servo_;
    haptable_model model_;
    std::optional<ServoPair> pair_;
    haptable_pair_model pair_model_{};  ///< where there is one
    std::optional<haptable_body> body_;
    std::optional<VibrationTables> vibration_;  ///< of a body that rings
    ServoVibration servo_vibration_;            ///< the servo's of it
    haptable_modes modes_{};
    std::optional<ContactLoads> mask_;             ///< with force = "pressure-mask"
    std::optional<MappedNpy<float>> columns_;      ///< [n, r, 3, 3]
    std::optional<MappedNpy<Half>> half_columns_;  ///< the same, in units of tables_.column_unit_m_per_n
    std::vector<std::int32_t> column_of_;          ///< [N] of a mesh node, or -1
};

}  // namespace haptable
