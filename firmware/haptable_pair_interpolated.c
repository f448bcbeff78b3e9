/* SPDX-License-Identifier: MIT
 *
 * [S_1 X; X^T S_2] v = [S_1 u_1; S_2 u_2],   X = sum_ab alpha_a alpha_b S_a L_ab S_b,   F_a = alpha_a S_a v
 *
 * The paper's interpolated force for two: each finger's nodal forces are eq. 10's for a displacement v that it would
 * have alone, and what they do at the other's place is weighted as these are. So C_cc = S(g_c)^-1 and C_12 = sum W_a^T
 * L_ab W_b with W_a = alpha_a S_a S^-1; C is positive definite, for f^T S^-1 f >= f^T C_12(g, g) f (the squares' mean
 * is not below the mean's square).
 */
#include "haptable_block.h"
#include "haptable_pair_terms.h"

/* S of a corner, read where it stands or expanded into `room`. */
static inline const float* corner_block(const struct haptable_model* model, uint16_t vertex, float room[6]) {
    if (vertex < model->free_count) return block_of(model, vertex, room);
    room[0] = room[1] = room[2] = model->rigid_stiffness_n_per_m;
    room[3] = room[4] = room[5] = 0.0f;
    return room;
}

/* sum alpha_a S_a */
static void stiffness_at(const struct haptable_model* model, const struct haptable_contact* contact, float s[6]) {
    const uint16_t* v = model->patch[contact->patch];
    float room[6];
    set_block(contact->alpha[0], corner_block(model, v[0], room), s);
    add_block(contact->alpha[1], corner_block(model, v[1], room), s);
    add_block(contact->alpha[2], corner_block(model, v[2], room), s);
}

static void own_at(const struct haptable_model* model, const struct haptable_contact* contact, const float finger_m[3],
                   struct haptable_pair_own* own) {
    float u[3];
    vec_sub(finger_m, contact->god_object_m, u);
    stiffness_at(model, contact, own->a);
    vec_symmetric_product(own->a, u, own->s);
}

static void put_load(const struct haptable_model* model, const struct haptable_contact* contact, const float v[3],
                     float nodal_force_n[3][3], float force_n[3]) {
    int corner;
    vec_zero(force_n);
    for (corner = 0; corner < 3; ++corner) {
        float f[3];
        block_product(model, model->patch[contact->patch][corner], v, f);
        vec_zero(nodal_force_n[corner]);
        vec_add_scaled(contact->alpha[corner], f, nodal_force_n[corner]);
        vec_add_scaled(-1.0f, nodal_force_n[corner], force_n);
    }
}

const struct haptable_pair_law haptable_pair_interpolated = {3, 1, own_at, put_load};

/* sum alpha_a S_a with its three S_a */
static void open_at(const struct haptable_model* model, const struct haptable_contact* contact, const float finger_m[3],
                    struct haptable_pair_point* point) {
    int a;
    for (a = 0; a < 3; ++a) {
        float room[6];
        const float* block = corner_block(model, model->patch[contact->patch][a], room);
        set_block(1.0f, block, point->linear[a]);
    }
    evaluate_c(point->linear, contact->alpha, point->own.a);
    point->lifted = point->steps = 0;
    vec_sub(finger_m, contact->god_object_m, point->own.s);
    {
        float u[3];
        vec_copy(point->own.s, u);
        vec_symmetric_product(point->own.a, u, point->own.s);
    }
}

/* s_b = S_b u - S e_b, s_bc = -S_b e_c - S_c e_b */
static void slope_at(const struct haptable_model* model, const struct haptable_contact* contact,
                     const float finger_m[3], struct haptable_pair_point* point, const float v[3],
                     struct haptable_pair_slope* slope) {
    float(*s_v)[3] = slope->a_v; /* S_b v */
    float e[2][3];
    float normal[3];
    float u[3];
    int b;
    vec_sub(finger_m, contact->god_object_m, u);
    patch_frame(model, contact->patch, e[0], e[1], normal);
    for (b = 0; b < 2; ++b) {
        float* y = slope->y[b];
        float first[6];
        float s_e[3];
        set_block(1.0f, point->linear[b + 1], first);
        add_block(-1.0f, point->linear[0], first);
        vec_symmetric_product(first, v, s_v[b]);
        vec_symmetric_product(first, u, y);
        vec_symmetric_product(point->own.a, e[b], s_e);
        vec_sub(y, s_e, y);
        vec_sub(y, s_v[b], y);
        slope->first_j[b] = vec_dot(y, v) + 0.5f * vec_dot(v, s_v[b]);
    }
    slope->second_j[0] = -2.0f * vec_dot(s_v[0], e[0]);
    slope->second_j[1] = -vec_dot(s_v[0], e[1]) - vec_dot(s_v[1], e[0]);
    slope->second_j[2] = -2.0f * vec_dot(s_v[1], e[1]);
}

const struct haptable_pair_bend haptable_pair_bend_interpolated = {open_at, slope_at};
