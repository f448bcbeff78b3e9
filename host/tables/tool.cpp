// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/tool.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/base/tool_range.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

constexpr const char* kFile = "tool.json";
constexpr const char* kSurface = "tool_surface.npy";

void require_tool(const TablesFolder& folder, const ToolTables& tables) {
    const auto is_finite = [](const std::array<double, 3>& p) {
        return std::all_of(p.begin(), p.end(), [](double x) { return std::isfinite(x); });
    };
    const std::size_t count = tables.point_m.size();
    if (count < kFewestPoints || count > kMostPoints)
        folder.fail(kFile, fmt::format("has {} points, and a tool has 2 to 32", count));
    if (!std::all_of(tables.point_m.begin(), tables.point_m.end(), is_finite))
        folder.fail(kFile, "has a point that is not finite");
    if (!(tables.max_torque_n_m > 0.0 && std::isfinite(tables.max_torque_n_m)))
        folder.fail(kFile, fmt::format("max_torque_n_m = {} is none: it is above 0", tables.max_torque_n_m));
    for (const double stiffness : {tables.stiffness_n_per_m, tables.turn_stiffness_n_m_per_rad})
        if (!(stiffness >= 0.0 && std::isfinite(stiffness)))
            folder.fail(kFile, fmt::format("has the stiffness {}, and none is below 0", stiffness));
}

std::vector<std::array<float, 3>> read_surface(const TablesFolder& folder) {
    const Array<float> array = read_npy<float>(folder.file(kSurface));
    if (array.shape.size() != 3 || array.shape[1] != 3 || array.shape[2] != 3)
        folder.fail(kSurface, "has no triangles: its shape is to be [t,3,3]");
    std::vector<std::array<float, 3>> corners(array.values.size() / 3);
    for (std::size_t i = 0; i < array.values.size(); ++i) {
        if (!std::isfinite(array.values[i])) folder.fail(kSurface, fmt::format("number {} of it is not finite", i));
        corners[i / 3][i % 3] = array.values[i];
    }
    return corners;
}

}  // namespace

void write_tool(const ToolTables& tables, const std::filesystem::path& folder) {
    const nlohmann::ordered_json json{{"point_m", tables.point_m},
                                      {"max_torque_n_m", tables.max_torque_n_m},
                                      {"stiffness_n_per_m", tables.stiffness_n_per_m},
                                      {"turn_stiffness_n_m_per_rad", tables.turn_stiffness_n_m_per_rad},
                                      {"spacing_m", tables.spacing_m}};
    write_file(folder / kFile, json_text(json, 1) + "\n");
    if (tables.surface_corner_m.empty()) return;
    const std::span<const float> corners(tables.surface_corner_m[0].data(), 3 * tables.surface_corner_m.size());
    write_npy<float>(folder / kSurface, {tables.surface_corner_m.size() / 3, 3, 3}, corners);
}

std::optional<ToolTables> read_tool(const TablesFolder& folder) {
    if (!folder.has(kFile)) return {};
    try {
        const auto json = parse_json(read_file(folder.file(kFile)));
        ToolTables tables;
        json.at("point_m").get_to(tables.point_m);
        json.at("max_torque_n_m").get_to(tables.max_torque_n_m);
        json.at("stiffness_n_per_m").get_to(tables.stiffness_n_per_m);
        json.at("turn_stiffness_n_m_per_rad").get_to(tables.turn_stiffness_n_m_per_rad);
        json.at("spacing_m").get_to(tables.spacing_m);
        require_tool(folder, tables);
        if (folder.has(kSurface)) tables.surface_corner_m = read_surface(folder);
        return tables;
    } catch (const nlohmann::json::exception& error) {
        folder.fail(kFile, error.what());
    }
}

}  // namespace haptable
