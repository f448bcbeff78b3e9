// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/tool.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/bytes.hpp"
#include "codegen/number.hpp"
#include "host/base/tool_range.hpp"

namespace haptable {

namespace {

static_assert(kMostPoints == HAPTABLE_POINTS);

float finite_in_tool(double value) {
    return to_float(value, "tool.json holds a number that is beyond a float's range");
}

}  // namespace

ToolPoints points_of(const ToolTables& tool) {
    ToolPoints points;
    for (const auto& p : tool.point_m)
        points.push_back({finite_in_tool(p[0]), finite_in_tool(p[1]), finite_in_tool(p[2])});
    return points;
}

haptable_tool_model tool_in_memory(const ToolTables& tool, const ToolPoints& point, const haptable_pair_model& pair) {
    haptable_tool_model to{};
    haptable_points_model_make(&pair, &to.points);
    to.points.count = static_cast<std::uint16_t>(point.size());
    haptable_tool_lay_out(&to.points);
    to.span = haptable_span_of_tool;
    to.point_m = reinterpret_cast<const float(*)[3]>(point.data());
    to.max_torque_n_m = finite_in_tool(tool.max_torque_n_m);
    to.stiffness_n_per_m = finite_in_tool(tool.stiffness_n_per_m);
    to.turn_stiffness_n_m_per_rad = finite_in_tool(tool.turn_stiffness_n_m_per_rad);
    for (const auto& p : point) to.reach_m = std::max(to.reach_m, std::hypot(p[0], p[1], p[2]));
    to.crc = pair.model->check != nullptr ? haptable_crc_of(&to, to.span) : 0;
    return to;
}

std::string tool_bytes(const haptable_tool_model& from) {
    const std::uint32_t point_count = from.points.count;
    Bytes bytes;
    bytes.add(point_count);
    HAPTABLE_TOOL_FIELDS(HAPTABLE_ADD_VALUE, HAPTABLE_ADD_TABLE)
    return bytes.take();
}

std::vector<TableBytes> flash_tables(const ToolPoints& point) {
    return {{"tool_point", point.size() * sizeof point[0]}};
}

void add_tool_values(const haptable_tool_model& tool, TemplateValues& values) {
    std::string points, fields;
    for (std::size_t i = 0; i < tool.points.count; ++i)
        points += fmt::format("    {{{}, {}, {}}},\n", literal(tool.point_m[i][0]), literal(tool.point_m[i][1]),
                              literal(tool.point_m[i][2]));
    for (const auto& [name, value] : {std::pair{"max_torque_n_m", tool.max_torque_n_m},
                                      {"reach_m", tool.reach_m},
                                      {"stiffness_n_per_m", tool.stiffness_n_per_m},
                                      {"turn_stiffness_n_m_per_rad", tool.turn_stiffness_n_m_per_rad}})
        if (value != 0.0F) fields += fmt::format("    .{} = {},\n", name, literal(value));
    values["tool_version"] = std::to_string(HAPTABLE_TOOL_VERSION);
    values["point_count"] = std::to_string(tool.points.count);
    values["tool_points"] = points;
    values["tool_fields"] = fields;
    values["tool_crc"] = tool.crc != 0 ? fmt::format("{:08x}", tool.crc) : "";
}

}  // namespace haptable
