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

/* S_b - S_0 (b = 1, 2) */
static void stiffness_slope(const struct haptable_model* model, uint16_t patch, float first[2][6]) {
    const uint16_t* v = model->patch[patch];
    float room[6];
    int b;
    for (b = 0; b < 2; ++b) {
        set_block(1.0f, corner_block(model, v[b + 1], room), first[b]);
        add_block(-1.0f, corner_block(model, v[0], room), first[b]);
    }
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

/* s_b - S_b v, and v . s_bc. */
static void vary_own(float first[2][6], const float s[6], float e[2][3], const float u[3], const float v[3],
                     float y[2][3], float second_j[3]) {
    float s_v[2][3]; /* S_b v */
    int b;
    for (b = 0; b < 2; ++b) {
        float s_u[3];
        vec_symmetric_product(first[b], v, s_v[b]);
        vec_symmetric_product(first[b], u, s_u);
        vec_symmetric_product(s, e[b], y[b]);
        vec_sub(s_u, y[b], y[b]);
        vec_sub(y[b], s_v[b], y[b]);
    }
    second_j[0] = -2.0f * vec_dot(s_v[0], e[0]);
    second_j[1] = -vec_dot(s_v[0], e[1]) - vec_dot(s_v[1], e[0]);
    second_j[2] = -2.0f * vec_dot(s_v[1], e[1]);
}

void haptable_pair_energy_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                                       const float finger_m[3], enum haptable_energy_terms terms,
                                       struct haptable_energy* energy) {
    const struct haptable_pair_view* view = pair_view_of(model);
    struct haptable_pair_own own;
    struct pair_coupling coupling;
    struct pair_solved solved;
    float first[2][6];
    float e[2][3];
    float y[2][3];
    float normal[3];
    float u[3];
    int b;
    if (!view->is_coupled) {
        haptable_energy_interpolated(model, contact, finger_m, terms, energy);
        return;
    }
    patch_frame(model, contact->patch, e[0], e[1], normal);
    vec_sub(finger_m, contact->god_object_m, u);
    stiffness_at(model, contact, own.a);
    stiffness_slope(model, contact->patch, first);
    vec_symmetric_product(own.a, u, own.s);
    pair_couple(view, contact, e, &coupling);
    pair_solve(view, &own, coupling.x, &solved);
    vec_symmetric_product(own.a, solved.v, energy->load_n);
    energy->energy_j = solved.energy_j;
    vary_own(first, own.a, e, u, solved.v, y, energy->hessian_j);
    for (b = 0; b < 2; ++b) {
        float s_v[3];
        vec_symmetric_product(first[b], solved.v, s_v);
        energy->gradient_j[b] = vec_dot(y[b], solved.v) + 0.5f * vec_dot(solved.v, s_v) -
                                pair_bilinear(coupling.first[b], solved.v, solved.other);
        vec_copy(s_v, energy->load_gradient_n[b]);
    }
    if (terms != HAPTABLE_ENERGY_ALL) return;
    pair_bend(view, &coupling, &solved, y, energy);
    for (b = 0; b < 2; ++b) { /* S_b v + S v_b */
        float s_z[3];
        vec_symmetric_product(own.a, y[b], s_z);
        vec_add_scaled(1.0f, s_z, energy->load_gradient_n[b]);
    }
}
