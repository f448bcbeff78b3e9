// SPDX-License-Identifier: GPL-2.0-or-later
// A rigid tool, as the servo holds it: beside its model and what couples two places, in the same two files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "codegen/size.hpp"
#include "codegen/template.hpp"
#include "firmware/haptable_tool.h"
#include "host/tables/tool.hpp"

namespace haptable {

using ToolPoints = std::vector<std::array<float, 3>>;  ///< m, about the handle

/// Throws Error where a number is no float's.
ToolPoints points_of(const ToolTables& tool);

/// Points to the coupling and to the points, which must outlive it.
haptable_tool_model tool_in_memory(const ToolTables& tool, const ToolPoints& point, const haptable_pair_model& pair);

/// Its fields in the order of HAPTABLE_TOOL_FIELDS, tables after their number of rows (32 bits).
std::string tool_bytes(const haptable_tool_model& tool);

/// Bytes of flash, by table.
std::vector<TableBytes> flash_tables(const ToolPoints& point);

/// What model.h and model.c say of it.
void add_tool_values(const haptable_tool_model& tool, TemplateValues& values);

}  // namespace haptable
