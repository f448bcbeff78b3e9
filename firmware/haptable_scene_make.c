/* SPDX-License-Identifier: MIT
 *
 * Tables -> scene, as codegen writes one: for programs that read tables at run time
 */
#include "haptable_patch.h"
#include "haptable_scene.h"
#include "haptable_surface.h"

/* The sine squared of a corner's angle below which one edge there may be next to a point of the other that is out of
 * reach of the vertex: HAPTABLE_EDGE_REACH / HAPTABLE_VERTEX_REACH, with room. */
#define SHARP2 0.09f

static int has_sharp_corner(const float edge1[3], const float edge2[3], const float normal[3]) {
    const float across2 = vec_length2(normal);
    const float a2 = vec_length2(edge1);
    const float b2 = vec_length2(edge2);
    const float c2 = gap2(edge1, edge2);
    return across2 <= SHARP2 * a2 * b2 || across2 <= SHARP2 * b2 * c2 || across2 <= SHARP2 * c2 * a2;
}

void haptable_model_surface(struct haptable_model* model) {
    model->hinges = model->hinge_count > 0u ? &haptable_hinges_of_table : 0;
    model->slivers = 0;
    for (uint16_t patch = 0; patch < model->patch_count; ++patch) {
        const uint16_t* across = model->neighbour[patch];
        float edge1[3], edge2[3], normal[3];
        if (across[0] == HAPTABLE_NONE || across[1] == HAPTABLE_NONE || across[2] == HAPTABLE_NONE)
            model->hinges = &haptable_hinges_of_table;
        patch_frame(model, patch, edge1, edge2, normal);
        if (haptable_patch_has_thin_frame(model, edge1, edge2, normal))
            model->slivers = &haptable_slivers_of_patches;
        else if (!model->slivers && has_sharp_corner(edge1, edge2, normal))
            model->slivers = &haptable_slivers_of_corners;
    }
}

/* Room for a struct of that size, at a multiple of 16. */
static uint32_t take_room(uint32_t bytes, uint32_t* end) {
    const uint32_t at = (*end + 15u) & ~15u;
    *end = at + bytes;
    return at;
}

void haptable_scene_make(const struct haptable_model* model, const struct haptable_pair_model* pair,
                         const struct haptable_body* body, const struct haptable_modes* modes,
                         struct haptable_scene* scene) {
#define PART(NAME, ...) &haptable_part_##NAME,
    static const struct haptable_rigid_part* const rigid[] = {HAPTABLE_RIGID_MOVERS(PART)};
#undef PART
    uint32_t end = (uint32_t)(pair ? sizeof(struct haptable_pair) : sizeof(struct haptable_servo));
    if (model->frictionless || model->term_count > 0) end = (uint32_t)sizeof(struct haptable_room);
    scene->model = model;
    scene->pair = pair;
    scene->body = body;
    scene->modes = modes;
    scene->init = pair ? haptable_init_two : haptable_init_one;
    scene->contacts = pair ? haptable_contacts_of_two : haptable_contact_of_one;
    scene->step = body || modes ? (model->stiffen ? haptable_moving_stiffening : haptable_moving)
                  : pair        ? haptable_step_held
                                : haptable_step_one;
    scene->rigid = body && body->motion < HAPTABLE_RIGID_MOTIONS ? rigid[body->motion] : 0;
    scene->ringing = modes ? &haptable_part_modes : 0;
    scene->rows = !modes ? 0 : pair ? haptable_rows_of_two : haptable_rows_of_one;
    scene->part = pair || body || modes ? haptable_part_of : 0;
    scene->body_at = body ? take_room((uint32_t)sizeof(struct haptable_body_state), &end) : 0u;
    scene->modes_at = modes ? take_room((uint32_t)sizeof(struct haptable_modes_state), &end) : 0u;
    scene->account_at = body || modes ? take_room((uint32_t)sizeof(struct haptable_account), &end) : 0u;
    scene->bytes = end;
}
