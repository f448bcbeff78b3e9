/* SPDX-License-Identifier: MIT
 *
 * E = 1/2 u^T S u,   S = sum alpha_a S_a,   dE/db = -e_b . S u + 1/2 u^T (S_b - S_0) u
 *
 * d2E/db dc = e_b^T S e_c - e_b^T (S_c - S_0) u - e_c^T (S_b - S_0) u: the first term is never negative.
 */
#include "haptable_block.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* sum alpha_a S_a */
static void stiffness_at(const struct haptable_model* model, const struct haptable_contact* contact, float s[6]) {
    for (int i = 0; i < 6; ++i) s[i] = 0.0f;
    for (int corner = 0; corner < 3; ++corner) {
        const uint16_t vertex = model->patch[contact->patch][corner];
        const float alpha = contact->alpha[corner];
        if (vertex < model->free_count) {
            float room[6];
            const float* block = block_of(model, vertex, room);
            for (int i = 0; i < 6; ++i) s[i] += alpha * block[i];
        } else {
            for (int i = 0; i < 3; ++i) s[i] += alpha * model->rigid_stiffness_n_per_m;
        }
    }
}

/* S u, and in f what S_a u (a = 1, 2) is over S_0 u. */
static void load_at(const struct haptable_model* model, const struct haptable_contact* contact, const float u[3],
                    float (*f)[3], float load_n[3]) {
    vec_zero(load_n);
    for (int a = 0; a < 3; ++a) {
        block_product(model, model->patch[contact->patch][a], u, f[a]);
        vec_add_scaled(contact->alpha[a], f[a], load_n);
    }
    vec_add_scaled(-1.0f, f[0], f[1]);
    vec_add_scaled(-1.0f, f[0], f[2]);
}

static void put_second_order(const struct haptable_model* model, const struct haptable_contact* contact, float (*e)[3],
                             float (*f)[3], struct haptable_energy* energy) {
    float s[6], s_e[2][3];
    stiffness_at(model, contact, s);
    for (int b = 0; b < 2; ++b) {
        vec_symmetric_product(s, e[b], s_e[b]);
        vec_sub(f[b + 1], s_e[b], energy->load_gradient_n[b]);
    }
    energy->gauss_newton_j[0] = vec_dot(e[0], s_e[0]);
    energy->gauss_newton_j[1] = vec_dot(e[0], s_e[1]);
    energy->gauss_newton_j[2] = vec_dot(e[1], s_e[1]);
    energy->hessian_j[0] = energy->gauss_newton_j[0] - 2.0f * vec_dot(e[0], f[1]);
    energy->hessian_j[1] = energy->gauss_newton_j[1] - vec_dot(e[0], f[2]) - vec_dot(e[1], f[1]);
    energy->hessian_j[2] = energy->gauss_newton_j[2] - 2.0f * vec_dot(e[1], f[2]);
}

void haptable_energy_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                                  const float finger_m[3], enum haptable_energy_terms terms,
                                  struct haptable_energy* energy) {
    float u[3], f[3][3], e[2][3], normal[3];
    vec_sub(finger_m, contact->god_object_m, u);
    load_at(model, contact, u, f, energy->load_n);
    energy->energy_j = 0.5f * vec_dot(u, energy->load_n);
    patch_frame(model, contact->patch, e[0], e[1], normal);
    for (int b = 0; b < 2; ++b) energy->gradient_j[b] = -vec_dot(e[b], energy->load_n) + 0.5f * vec_dot(u, f[b + 1]);
    if (terms == HAPTABLE_ENERGY_ALL) put_second_order(model, contact, e, f, energy);
}
