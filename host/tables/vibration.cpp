// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/vibration.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <span>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

template <typename T>
void write_vectors(const fs::path& path, std::size_t modes, const std::vector<std::array<T, 3>>& vectors) {
    const T* first = vectors.empty() ? nullptr : vectors.front().data();
    write_npy<T>(path, {vectors.size() / modes, modes, 3}, std::span<const T>(first, 3 * vectors.size()));
}

template <typename T>
std::vector<std::array<T, 3>> read_vectors(const fs::path& path, std::size_t modes) {
    const Array<T> array = read_npy<T>(path);
    if (array.shape.size() != 3 || array.shape[1] != modes || array.shape[2] != 3)
        throw Error(
            fmt::format("{}: is not of the {} modes of modes.json: make the tables again", path.string(), modes));
    std::vector<std::array<T, 3>> vectors(array.values.size() / 3);
    for (std::size_t i = 0; i < array.values.size(); ++i) vectors[i / 3][i % 3] = array.values[i];
    return vectors;
}

}  // namespace

void write_vibration(const VibrationTables& tables, const fs::path& folder) {
    nlohmann::ordered_json json{{"damping_ratio", tables.damping_ratio}, {"controls", tables.control_count}};
    json["omega_rad_per_s"] = tables.omega_rad_per_s;
    for (const double omega : tables.omega_rad_per_s) json["frequency_hz"].push_back(omega / (2.0 * std::numbers::pi));
    write_file(folder / "modes.json", json_text(json, 1) + "\n");
    write_vectors(folder / "mode_shape.npy", tables.modes(), tables.shape);
    if (!tables.row.empty()) write_vectors(folder / "mode_rows.npy", tables.modes(), tables.row);
}

std::optional<VibrationTables> read_vibration(const fs::path& folder) {
    const fs::path path = folder / "modes.json";
    if (!fs::exists(path)) return {};
    try {
        const auto json = parse_json(read_file(path));
        VibrationTables tables;
        json.at("damping_ratio").get_to(tables.damping_ratio);
        json.at("controls").get_to(tables.control_count);
        json.at("omega_rad_per_s").get_to(tables.omega_rad_per_s);
        tables.shape = read_vectors<double>(folder / "mode_shape.npy", tables.modes());
        if (tables.modes() == 0 || tables.shape.size() != tables.control_count * tables.modes())
            throw Error(fmt::format("{}: has {} places and modes.json {}: make the tables again",
                                    (folder / "mode_shape.npy").string(), tables.shape.size(), tables.control_count));
        if (fs::exists(folder / "mode_rows.npy"))
            tables.row = read_vectors<float>(folder / "mode_rows.npy", tables.modes());
        return tables;
    } catch (const nlohmann::json::exception& error) {
        throw Error(fmt::format("{}: {}: make the tables again", path.string(), error.what()));
    }
}

void refuse_vibration(const fs::path& folder, const char* who) {
    if (!fs::exists(folder / "modes.json")) return;
    throw Error(
        fmt::format("{}: its body rings, which {} cannot: remove modes from [body] of the scene and make the "
                    "tables again",
                    folder.string(), who));
}

}  // namespace haptable
