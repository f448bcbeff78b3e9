/* SPDX-License-Identifier: MIT
 *
 * s_b = r s_lin,b + r_b s_lin,   r_b = k e_b / (2 e),   r_bc = m e_b e_c / (2 e)^2 + k e_bc / (2 e)
 *
 * Derivatives of a stretched contact's terms (haptable_pair_stiffening.c), of those of the linear law at v, and at q,
 * where they are e's: e_b = s_lin,b . q - 1/2 q . A_b q, and so on.
 */
#include "haptable_pair_laws.h"
#include "haptable_pair_stiffening.h"

static void open_at(const struct haptable_model* model, int is_stiffness, struct haptable_pair_point* point) {
    struct stretch stretch;
    haptable_pair_stretch(model, point->own.a, is_stiffness, point->u, &stretch);
    vec_scale(stretch.r, point->own.s);
}

/* y_b . A^-1 y_c at q: of e_bc. */
static void put_bends(const struct haptable_pair_point* point, const struct haptable_pair_slope* alone,
                      float bend_j[3]) {
    const struct sym_factored factored = sym_factor(point->own.a);
    float z[2][3];
    for (int b = 0; b < 2; ++b) sym_solve(&factored, alone->y[b], z[b]);
    bend_j[0] = alone->second_j[0] + vec_dot(alone->y[0], z[0]);
    bend_j[1] = alone->second_j[1] + vec_dot(alone->y[0], z[1]);
    bend_j[2] = alone->second_j[2] + vec_dot(alone->y[1], z[1]);
}

/* before: slope is the linear law's at v, alone at w: A w = s_lin. */
static void stretch_slope(const struct stretch* stretch, const struct haptable_pair_point* point, int is_stiffness,
                          const struct haptable_pair_slope* alone, const float by[3], int is_whole,
                          struct haptable_pair_slope* slope) {
    const float* s = is_stiffness ? stretch->q : stretch->u;
    float s_b[2][3], r_b[2], bend_j[3];
    for (int b = 0; b < 2; ++b) {
        const float half_j = 0.5f * vec_dot(by, slope->a_v[b]);
        vec_add(slope->y[b], slope->a_v[b], s_b[b]);
        r_b[b] = stretch->k * stretch->per_j * alone->first_j[b];
        vec_zero(slope->y[b]);
        vec_add_scaled(stretch->r, s_b[b], slope->y[b]);
        vec_add_scaled(r_b[b], s, slope->y[b]);
        slope->first_j[b] = vec_dot(slope->y[b], by) - half_j;
        vec_sub(slope->y[b], slope->a_v[b], slope->y[b]);
    }
    if (!is_whole) return;
    put_bends(point, alone, bend_j);
    const float along_j = vec_dot(s, by);
    for (int i = 0; i < 3; ++i) { /* 11 12 22 */
        const int b = i == 2 ? 1 : 0;
        const int c = i == 0 ? 0 : 1;
        const float r_bc = stretch->per_j * (stretch->m * stretch->per_j * alone->first_j[b] * alone->first_j[c] +
                                             stretch->k * bend_j[i]);
        const float linear_j = is_stiffness ? (stretch->r - 1.0f) * slope->second_j[i] : 0.0f; /* s_bc . v */
        slope->second_j[i] += linear_j + r_b[b] * vec_dot(s_b[c], by) + r_b[c] * vec_dot(s_b[b], by) + r_bc * along_j;
    }
}

/* q of a compliance, u of a stiffness. */
static const float* alone_of(const struct stretch* stretch, int is_stiffness) {
    return is_stiffness ? stretch->u : stretch->q;
}

#define LAW(name, is_stiffness, linear)                                                                  \
    static void open_##name(const struct haptable_model* model, const struct haptable_contact* contact,  \
                            const float finger_m[3], struct haptable_pair_point* point) {                \
        haptable_pair_open_##name(model, contact, finger_m, point);                                      \
        open_at(model, is_stiffness, point);                                                             \
    }                                                                                                    \
    static void slope_##name(const struct haptable_model* model, const struct haptable_contact* contact, \
                             struct haptable_pair_point* point, const float v[3], int is_whole,          \
                             struct haptable_pair_slope* slope) {                                        \
        const float by[3] = {v[0], v[1], v[2]}; /* apart from what is written */                         \
        struct haptable_pair_slope alone;                                                                \
        struct stretch stretch;                                                                          \
        haptable_pair_stretch(model, point->own.a, is_stiffness, point->u, &stretch);                    \
        linear(model, contact, point, alone_of(&stretch, is_stiffness), is_whole, &alone);               \
        linear(model, contact, point, by, is_whole, slope);                                              \
        stretch_slope(&stretch, point, is_stiffness, &alone, by, is_whole, slope);                       \
    }                                                                                                    \
    const struct haptable_pair_bend haptable_pair_bend_stiffening_##name = {open_##name, slope_##name};

LAW(interpolated, 1, haptable_pair_slope_interpolated)
LAW(consistent, 0, haptable_pair_slope_consistent)
LAW(pressure_mask, 0, haptable_pair_slope_mask)
LAW(consistent_packed, 0, haptable_pair_slope_consistent)
LAW(pressure_mask_packed, 0, haptable_pair_slope_mask)
