/* SPDX-License-Identifier: MIT
 *
 * Tables -> scene with three fingers and more, as codegen writes one: for programs that read tables at run time
 */
#include "haptable_hands.h"

void haptable_hands_scene_make(const struct haptable_pair_model* pair, struct haptable_points_model* points,
                               struct haptable_points_scene* scene) {
    haptable_points_model_make(pair, points);
    points->state_at = (uint32_t)offsetof(struct haptable_hands_room, hands.points);
    points->servos_at = (uint32_t)offsetof(struct haptable_hands_room, servo);
    points->points_at = (uint32_t)offsetof(struct haptable_hands_room, point);
    points->system_at = (uint32_t)offsetof(struct haptable_hands_room, system);
    points->count = pair->finger_count;
    haptable_scene_make(pair->model, pair, 0, 0, &scene->scene);
    scene->points = points;
    scene->scene.init = haptable_init_hands;
    scene->scene.contacts = 0;
    scene->scene.step = haptable_step_hands;
    scene->scene.bytes = (uint32_t)sizeof(struct haptable_hands_room);
}
