// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/library/object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "codegen/in_memory.hpp"
#include "codegen/rigid_body.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// What precompute wrote of itself. Throws Error where a file is another than it was.
json checked_summary(const fs::path& folder) {
    if (!fs::exists(folder / "summary.json"))
        throw Error((folder / "summary.json").string() + ": is not there: make the tables with haptable-precompute");
    json summary = parse_json_or_discard(read_file(folder / "summary.json"));
    if (!summary.is_object() || !summary.contains("hash") || !summary.contains("tables_hash"))
        throw Error((folder / "summary.json").string() + ": is not a summary of haptable-precompute");
    for (const auto& [file, hash] : summary["hash"].items())
        if (hash != hash_file(folder / file))
            throw Error(fmt::format("{}: is missing or not what haptable-precompute wrote: make the tables again",
                                    (folder / file).string()));
    return summary;
}

float to_number(float value) { return value; }
float to_number(Half value) { return to_float(value); }

}  // namespace

LoadedObject::LoadedObject(const fs::path& folder, std::uint64_t wanted) {
    const json summary = checked_summary(folder);
    tables_ = read_tables(folder);
    servo_ = build_model(tables_);
    model_ = model_in_memory(tables_, servo_);
    const std::string built = fmt::format("{:016x}", model_.hash);
    if (summary["tables_hash"] != built)
        throw Error(fmt::format("{}: its tables make {}, not its tables_hash: make them again with this version",
                                (folder / "summary.json").string(), built));
    if (wanted != 0 && wanted != model_.hash)
        throw Error(
            fmt::format("{}: holds the tables {}, not the {:016x} that are wanted", folder.string(), built, wanted));
    if (tables_.force == ForceLaw::kPressureMask) mask_.emplace(tables_);
    if (const std::optional<PairTables> pair = read_pair(folder)) {
        pair_ = build_pair(*pair, tables_, servo_);
        pair_model_ = pair_in_memory(*pair_, tables_, model_);
    }
    body_ = read_rigid_body(folder);
    if ((vibration_ = read_vibration(folder))) {
        servo_vibration_ = build_vibration(*vibration_, tables_, servo_);
        modes_ = vibration_in_memory(servo_vibration_);
        if (rows() > 0 && vibration_->row.size() != rows() * vibration_->modes())
            throw Error((folder / "mode_rows.npy").string() + ": does not fit row_id.npy: make the tables again");
    }
    if (tables_.has_columns) open_columns(folder);
}

void LoadedObject::open_columns(const fs::path& folder) {
    const fs::path file = folder / "columns.npy";
    if (tables_.half_columns)
        half_columns_.emplace(file);
    else
        columns_.emplace(file);
    const std::vector<std::size_t>& shape = columns_ ? columns_->shape() : half_columns_->shape();
    if (shape != std::vector<std::size_t>{tables_.node_id.size(), tables_.row_id.size(), 3, 3})
        throw Error(file.string() + ": does not fit the other tables: make them again");
    column_of_.assign(tables_.position.size(), -1);
    for (std::size_t i = 0; i < tables_.node_id.size(); ++i)
        column_of_[static_cast<std::size_t>(tables_.node_id[i])] = static_cast<std::int32_t>(i);
}

/// displacement += L[:, node] force
template <typename Number>
void LoadedObject::add_column(std::span<const Number> column, const NodalForce& load,
                              std::span<const std::uint32_t> row, std::span<float> displacement_m) const {
    const float unit = tables_.half_columns ? static_cast<float>(tables_.column_unit_m_per_n) : 1.0F;
    const std::array<float, 3> f{unit * load.force_n[0], unit * load.force_n[1], unit * load.force_n[2]};
    for (std::size_t k = 0; 3 * k < displacement_m.size(); ++k) {
        const Number* block = &column[9 * (row.empty() ? k : std::size_t{row[k]})];
        for (std::size_t c = 0; c < 3; ++c, block += 3)
            displacement_m[3 * k + c] +=
                to_number(block[0]) * f[0] + to_number(block[1]) * f[1] + to_number(block[2]) * f[2];
    }
}

void LoadedObject::require_rows(std::span<const std::uint32_t> row) const {
    if (!tables_.has_columns)
        throw Error(fmt::format(
            "{} has no columns.npy, by which a body is deformed: {}", tables_.name,
            tables_.has_factor ? "raise tables.column_budget in the scene" : "leave out tables.columns = \"none\""));
    for (const std::uint32_t k : row)
        if (k >= rows()) throw Error(fmt::format("there is no row {}: {} has {}", k, tables_.name, rows()));
}

void LoadedObject::swing(std::span<const float> swung, std::span<const std::uint32_t> row,
                         std::span<float> displacement_m) const {
    require_rows(row);
    for (std::size_t i = 0; 3 * i < displacement_m.size(); ++i)
        for (std::size_t k = 0; k < swung.size(); ++k)
            for (std::size_t c = 0; c < 3; ++c)
                displacement_m[3 * i + c] +=
                    vibration_->row[(row.empty() ? i : std::size_t{row[i]}) * swung.size() + k][c] * swung[k];
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
        if (columns_)
            add_column(columns_->values().subspan(begin, width), load, row, displacement_m);
        else
            add_column(half_columns_->values().subspan(begin, width), load, row, displacement_m);
    }
}

}  // namespace haptable
