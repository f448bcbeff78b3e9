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
#include "haptable_pair_laws.h"
#include "haptable_polynomial.h"

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
    float room[3][6];
    mix_three(contact->alpha, corner_block(model, v[0], room[0]), corner_block(model, v[1], room[1]),
              corner_block(model, v[2], room[2]), s);
}

void haptable_pair_own_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float finger_m[3], struct haptable_pair_own* own) {
    float u[3];
    vec_sub(finger_m, contact->god_object_m, u);
    stiffness_at(model, contact, own->a);
    vec_symmetric_product(own->a, u, own->s);
}

void haptable_pair_load_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                                     const float v[3], float nodal_force_n[3][3], float force_n[3]) {
    const float by[3] = {v[0], v[1], v[2]}; /* apart from what is written */
    float sum[3] = {0.0f, 0.0f, 0.0f};
    for (int corner = 0; corner < 3; ++corner) {
        const float w = contact->alpha[corner];
        float room[6], f[3];
        vec_symmetric_product(corner_block(model, model->patch[contact->patch][corner], room), by, f);
        f[0] *= w;
        f[1] *= w;
        f[2] *= w;
        vec_sub(sum, f, sum);
        vec_copy(f, nodal_force_n[corner]);
    }
    vec_copy(sum, force_n);
}

const struct haptable_pair_law haptable_pair_interpolated = {3, 1, haptable_pair_own_interpolated,
                                                             haptable_pair_load_interpolated, 0};

/* sum alpha_a S_a with its three S_a */
void haptable_pair_open_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                                     const float finger_m[3], struct haptable_pair_point* point) {
    const uint16_t* v = model->patch[contact->patch];
    const float** s = point->net.block;
    s[0] = corner_block(model, v[0], point->net.room[0]);
    s[1] = corner_block(model, v[1], point->net.room[1]);
    s[2] = corner_block(model, v[2], point->net.room[2]);
    mix_three(contact->alpha, s[0], s[1], s[2], point->own.a);
    point->lifted = point->steps = 0;
    edges_of(model, contact->patch, point->e);
    vec_sub(finger_m, contact->god_object_m, point->u);
    vec_symmetric_product(point->own.a, point->u, point->own.s);
}

/* s_b = S_b u - S e_b, s_bc = -S_b e_c - S_c e_b */
void haptable_pair_slope_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                                      struct haptable_pair_point* point, const float v[3], int is_whole,
                                      struct haptable_pair_slope* slope) {
    const float* zero = point->net.block[0];
    float(*e)[3] = point->e;
    float by[3]; /* apart from what is written */
    float from[3];
    (void)model;
    (void)contact;
    vec_copy(v, by);
    vec_sub(point->u, by, from);
    for (int b = 0; b < 2; ++b) {
        const float* one = point->net.block[b + 1];
        const float first[6] = {one[0] - zero[0], one[1] - zero[1], one[2] - zero[2],
                                one[3] - zero[3], one[4] - zero[4], one[5] - zero[5]};
        float s_v[3]; /* S_b v */
        float s_e[3], y[3];
        vec_symmetric_product(first, by, s_v);
        vec_symmetric_product(first, from, y);
        vec_symmetric_product(point->own.a, e[b], s_e);
        vec_sub(y, s_e, y);
        slope->first_j[b] = vec_dot(y, by) + 0.5f * vec_dot(by, s_v);
        vec_copy(y, slope->y[b]);
        vec_copy(s_v, slope->a_v[b]);
    }
    if (!is_whole) return;
    slope->second_j[0] = -2.0f * vec_dot(slope->a_v[0], e[0]);
    slope->second_j[1] = -vec_dot(slope->a_v[0], e[1]) - vec_dot(slope->a_v[1], e[0]);
    slope->second_j[2] = -2.0f * vec_dot(slope->a_v[1], e[1]);
}

const struct haptable_pair_bend haptable_pair_bend_interpolated = {haptable_pair_open_interpolated,
                                                                   haptable_pair_slope_interpolated};
