// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/library/object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"

namespace haptable {

namespace {

float to_number(float value) { return value; }
float to_number(Half value) { return to_float(value); }

}  // namespace

LoadedObject::LoadedObject(const TablesFolder& folder, std::uint64_t wanted) : scene_(folder) {
    if (wanted != 0 && wanted != scene_.model().hash)
        throw Error(fmt::format("{}: holds the tables {:016x}, not the {:016x} that are wanted", folder.text(),
                                scene_.model().hash, wanted));
    map_columns();
}

LoadedObject::LoadedObject(SceneFiles files) : scene_(std::move(files)) { map_columns(); }

void LoadedObject::map_columns() {
    if (tables().force == ForceLaw::kPressureMask) mask_.emplace(tables());
    if (!tables().has_columns) return;
    const TablesFolder& folder = scene_.folder();
    columns_.emplace(tables(), folder);
    if (scene_.body_modes() != nullptr && scene_.body_modes()->row.empty())
        folder.fail("mode_rows.npy", "is missing, by which the columns' rows ring");
    column_of_.assign(tables().position.size(), -1);
    for (std::size_t i = 0; i < tables().node_id.size(); ++i)
        column_of_[static_cast<std::size_t>(tables().node_id[i])] = static_cast<std::int32_t>(i);
}

/// displacement += L[:, node] force
template <typename Number>
void LoadedObject::add_column(std::span<const Number> column, const NodalForce& load,
                              std::span<const std::uint32_t> row, std::span<float> displacement_m) const {
    const float unit = columns_->unit_m_per_n();
    const std::array<float, 3> f{unit * load.force_n[0], unit * load.force_n[1], unit * load.force_n[2]};
    for (std::size_t k = 0; 3 * k < displacement_m.size(); ++k) {
        const Number* block = &column[9 * (row.empty() ? k : std::size_t{row[k]})];
        for (std::size_t c = 0; c < 3; ++c, block += 3)
            displacement_m[3 * k + c] +=
                to_number(block[0]) * f[0] + to_number(block[1]) * f[1] + to_number(block[2]) * f[2];
    }
}

void LoadedObject::require_rows(std::span<const std::uint32_t> row) const {
    if (!columns_)
        throw Error(fmt::format(
            "{} has no columns.npy, by which a body is deformed: {}", tables().name,
            tables().has_factor ? "raise tables.column_budget in the scene" : "leave out tables.columns = \"none\""));
    for (const std::uint32_t k : row)
        if (k >= rows()) throw Error(fmt::format("there is no row {}: {} has {}", k, tables().name, rows()));
}

void LoadedObject::swing(std::span<const float> swung, std::span<const std::uint32_t> row,
                         std::span<float> displacement_m) const {
    require_rows(row);
    for (std::size_t i = 0; 3 * i < displacement_m.size(); ++i)
        for (std::size_t k = 0; k < swung.size(); ++k)
            for (std::size_t c = 0; c < 3; ++c)
                displacement_m[3 * i + c] +=
                    scene_.body_modes()->row[(row.empty() ? i : std::size_t{row[i]}) * swung.size() + k][c] * swung[k];
}

void LoadedObject::deform(const std::vector<NodalForce>& on_patch, std::span<const std::uint32_t> row,
                          std::span<float> displacement_m) const {
    require_rows(row);
    std::fill(displacement_m.begin(), displacement_m.end(), 0.0F);
    const std::size_t width = 9 * rows();
    for (const NodalForce& load : mask_ ? mask_->spread(on_patch) : on_patch) {
        const std::int32_t i = load.node < 0 ? -1 : column_of_[static_cast<std::size_t>(load.node)];
        if (i < 0) continue;  // held still
        const std::size_t begin = static_cast<std::size_t>(i) * width;
        if (columns_->is_half())
            add_column(columns_->half().subspan(begin, width), load, row, displacement_m);
        else
            add_column(columns_->single().subspan(begin, width), load, row, displacement_m);
    }
}

}  // namespace haptable
