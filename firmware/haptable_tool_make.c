/* SPDX-License-Identifier: MIT
 *
 * Tables -> scene with a tool, as codegen writes one: for programs that read tables at run time
 */
#include "haptable_tool.h"

void haptable_tool_scene_make(const struct haptable_model* model, const struct haptable_tool_model* tool,
                              struct haptable_points_scene* scene) {
    haptable_scene_make(model, 0, 0, 0, &scene->scene);
    scene->points = &tool->points;
    scene->scene.init = haptable_init_tool;
    scene->scene.step = haptable_step_tool;
    scene->scene.part = haptable_part_of_tool;
    scene->scene.bytes = (uint32_t)sizeof(struct haptable_tool_room);
}
