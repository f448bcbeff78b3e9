/* SPDX-License-Identifier: MIT
 *
 * A tool's values and tables, one after another: what its CRC is of
 */
#include "haptable_tool.h"

struct haptable_span haptable_span_of_tool(const void* of, uint32_t field) {
    const struct haptable_tool_model* tool = (const struct haptable_tool_model*)of;
    const struct haptable_span span[] = {
        {tool->point_m, (uint32_t)sizeof *tool->point_m * tool->points.count},
        {&tool->max_torque_n_m,
         (uint32_t)(offsetof(struct haptable_tool_model, turn_stiffness_n_m_per_rad) +
                    sizeof tool->turn_stiffness_n_m_per_rad - offsetof(struct haptable_tool_model, max_torque_n_m))},
        {tool, HAPTABLE_SPAN_END}};
    return span[field < 2u ? field : 2u];
}

struct haptable_part haptable_part_of_tool(const struct haptable_scene* scene, uint32_t number) {
    const struct haptable_tool_model* tool = haptable_tool_of(scene);
    struct haptable_part part = {0, 0, 0};
    if (number == 1u) {
        part.tables = tool->points.pair;
        part.span = tool->points.pair->span;
        part.crc = tool->points.pair->crc;
    } else if (number == 2u) {
        part.tables = tool;
        part.span = tool->span;
        part.crc = tool->crc;
    }
    return part;
}
