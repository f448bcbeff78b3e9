// SPDX-License-Identifier: GPL-2.0-or-later
// A scene's folder in memory: checked, then const.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "codegen/loaded_scene.hpp"
#include "codegen/loads.hpp"
#include "host/session/energy.hpp"
#include "host/session/scene_state.hpp"
#include "host/tables/columns.hpp"

namespace haptable {

class LoadedObject {
public:
    /// Throws Error that names the file: missing, or not what haptable-precompute wrote. wanted: tables_hash, or 0.
    LoadedObject(const TablesFolder& folder, std::uint64_t wanted);
    /// From files whose options somebody changed. Throws Error as LoadedScene does.
    explicit LoadedObject(SceneFiles files);
    LoadedObject(const LoadedObject&) = delete;
    LoadedObject& operator=(const LoadedObject&) = delete;

    const LoadedScene& scene() const { return scene_; }
    const Tables& tables() const { return scene_.tables(); }
    std::size_t rows() const { return columns_ ? columns_->rows() : 0; }
    /// Mesh node of a vertex of the model; -1: HAPTABLE_NONE.
    std::int32_t node_of(std::uint16_t vertex) const {
        return vertex == HAPTABLE_NONE ? -1 : scene_.servo().node[vertex];
    }

    /// u_r = sum L_ri F_i (equation 8) of the rows numbered by `row`, or, where it is empty, of all. displacement_m:
    /// [rows asked for, 3]. Throws Error without columns and for a row that there is not.
    void deform(const std::vector<NodalForce>& on_patch, std::span<const std::uint32_t> row,
                std::span<float> displacement_m) const;

    /// u_r += sum phi_kr q_k. swung: [modes]; else as deform().
    void swing(std::span<const float> swung, std::span<const std::uint32_t> row, std::span<float> displacement_m) const;

private:
    void map_columns();
    void require_rows(std::span<const std::uint32_t> row) const;
    template <typename Number>
    void add_column(std::span<const Number> column, const NodalForce& load, std::span<const std::uint32_t> row,
                    std::span<float> displacement_m) const;

    LoadedScene scene_;
    std::optional<ContactLoads> mask_;  ///< with force = "pressure-mask"
    std::optional<MappedColumns> columns_;
    std::vector<std::int32_t> column_of_;  ///< [N] of a mesh node, or -1
};

/// One finger on an object, or both of a pair: what stands behind a pointer of haptable_library.h. It holds the object:
/// whoever is freed last frees it.
struct Touching {
    std::shared_ptr<const LoadedObject> loaded;
    SceneState state;
    std::array<EnergyAccount, HAPTABLE_HANDS> energy{};
    std::array<std::uint32_t, HAPTABLE_HANDS> buttons{};  ///< held down
};

}  // namespace haptable

struct haptable_object {
    std::shared_ptr<const haptable::LoadedObject> loaded;
};
struct haptable_finger : haptable::Touching {};
struct haptable_fingers : haptable::Touching {};
struct haptable_held : haptable::Touching {};
