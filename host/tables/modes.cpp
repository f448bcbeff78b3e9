// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/modes.hpp"

#include <fmt/format.h>

#include <cmath>
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
std::vector<std::array<T, 3>> read_vectors(const TablesFolder& folder, const char* name, std::size_t modes) {
    const Array<T> array = read_npy<T>(folder.file(name));
    if (array.shape.size() != 3 || array.shape[1] != modes || array.shape[2] != 3)
        folder.fail(name, fmt::format("is not of the {} modes of modes.json", modes));
    std::vector<std::array<T, 3>> vectors(array.values.size() / 3);
    for (std::size_t i = 0; i < array.values.size(); ++i) {
        if (!std::isfinite(array.values[i])) folder.fail(name, fmt::format("number {} of it is not finite", i));
        vectors[i / 3][i % 3] = array.values[i];
    }
    return vectors;
}

/// Each mode comes back and fades.
void require_rings(const TablesFolder& folder, const ModeTables& tables) {
    if (tables.modes() == 0) folder.fail("modes.json", "names no mode");
    if (!(tables.damping_ratio > 0.0 && tables.damping_ratio < 1.0))
        folder.fail("modes.json", fmt::format("damping_ratio = {} is none: from 0 to 1", tables.damping_ratio));
    double before = 0.0;
    for (const double omega : tables.omega_rad_per_s) {
        if (!(omega > 0.0 && omega >= before && std::isfinite(omega)))
            folder.fail(
                "modes.json",
                fmt::format("omega_rad_per_s has {} after {}: frequencies are positive and ascend", omega, before));
        before = omega;
    }
}

}  // namespace

void write_modes(const ModeTables& tables, const fs::path& folder) {
    nlohmann::ordered_json json{{"damping_ratio", tables.damping_ratio}, {"controls", tables.control_count}};
    json["omega_rad_per_s"] = tables.omega_rad_per_s;
    for (const double omega : tables.omega_rad_per_s) json["frequency_hz"].push_back(omega / (2.0 * std::numbers::pi));
    write_file(folder / "modes.json", json_text(json, 1) + "\n");
    write_vectors(folder / "mode_shape.npy", tables.modes(), tables.shape);
    if (!tables.row.empty()) write_vectors(folder / "mode_rows.npy", tables.modes(), tables.row);
}

std::optional<ModeTables> read_modes(const TablesFolder& folder) {
    if (!folder.has("modes.json")) return {};
    try {
        const auto json = parse_json(read_file(folder.file("modes.json")));
        ModeTables tables;
        json.at("damping_ratio").get_to(tables.damping_ratio);
        json.at("controls").get_to(tables.control_count);
        json.at("omega_rad_per_s").get_to(tables.omega_rad_per_s);
        require_rings(folder, tables);
        tables.shape = read_vectors<double>(folder, "mode_shape.npy", tables.modes());
        if (tables.shape.size() != tables.control_count * tables.modes())
            folder.fail("mode_shape.npy",
                        fmt::format("has {} places and modes.json {}", tables.shape.size(), tables.control_count));
        if (folder.has("mode_rows.npy")) tables.row = read_vectors<float>(folder, "mode_rows.npy", tables.modes());
        return tables;
    } catch (const nlohmann::json::exception& error) {
        folder.fail("modes.json", error.what());
    }
}

}  // namespace haptable
