/* SPDX-License-Identifier: MIT
 *
 * Tables -> scene, as codegen writes one: for programs that read tables at run time
 */
#include "haptable_scene.h"

/* Room for a struct of that size, at a multiple of 16. */
static uint32_t take_room(uint32_t bytes, uint32_t* end) {
    const uint32_t at = (*end + 15u) & ~15u;
    *end = at + bytes;
    return at;
}

void haptable_scene_make(const struct haptable_model* model, const struct haptable_pair_model* pair,
                         const struct haptable_body* body, const struct haptable_modes* modes,
                         struct haptable_scene* scene) {
    uint32_t end = (uint32_t)(pair ? sizeof(struct haptable_pair) : sizeof(struct haptable_servo));
    if (model->frictionless || model->relax) end = (uint32_t)sizeof(struct haptable_room);
    scene->model = model;
    scene->pair = pair;
    scene->body = body;
    scene->modes = modes;
    scene->init = pair ? haptable_init_two : haptable_init_one;
    scene->contacts = pair ? haptable_contacts_of_two : haptable_contact_of_one;
    scene->step = body || modes ? haptable_moving : pair ? haptable_step_held : haptable_step_one;
    scene->rigid = body ? &haptable_part_rigid : 0;
    scene->ringing = modes ? &haptable_part_modes : 0;
    scene->rows = !modes ? 0 : pair ? haptable_rows_of_two : haptable_rows_of_one;
    scene->body_at = body ? take_room((uint32_t)sizeof(struct haptable_body_state), &end) : 0u;
    scene->modes_at = modes ? take_room((uint32_t)sizeof(struct haptable_modes_state), &end) : 0u;
    scene->account_at = body || modes ? take_room((uint32_t)sizeof(struct haptable_account), &end) : 0u;
    scene->bytes = end;
}
