// SPDX-License-Identifier: GPL-2.0-or-later
// A rigid tool: the files of a scene with [tool].
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "host/tables/folder.hpp"

namespace haptable {

/// Places are about the handle, in the tool's axes, m.
struct ToolTables {
    std::vector<std::array<double, 3>> point_m;          ///< [k] 2 to 32
    double max_torque_n_m = 0.0;                         ///< above 0
    double stiffness_n_per_m = 0.0;                      ///< of a virtual coupling; 0: none
    double turn_stiffness_n_m_per_rad = 0.0;             ///< the same
    double spacing_m = 0.0;                              ///< of points that sample a shape; 0: they are given
    std::vector<std::array<float, 3>> surface_corner_m;  ///< [3 t] corners of triangles, as the tool is drawn
};

/// tool.json and, of a shape, tool_surface.npy.
void write_tool(const ToolTables& tables, const std::filesystem::path& folder);

/// None where the folder's scene has no tool. Throws Error that names the file: missing, damaged or not fitting.
std::optional<ToolTables> read_tool(const TablesFolder& folder);

}  // namespace haptable
