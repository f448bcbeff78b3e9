/* SPDX-License-Identifier: MIT
 *
 * C of two contacts, as their forces were given: [C_11 C_12; C_21 C_22], six rows
 */
#include "haptable_pair_terms.h"
#include "haptable_rows.h"

#define ROWS HAPTABLE_ROWS

/* ---- C of the forces that were given ---------------------------------------------------------------------------- */

/* The root of what was lost of a force, by which C grows: limits may have lowered it. 0: there was none. */
static float growth_of(const struct haptable_pair_law* law, const struct haptable_pair_own* own, const float v[3],
                       const float given_n[3]) {
    const float given2 = vec_dot(given_n, given_n);
    float load_n[3];
    haptable_pair_load_of(law, own->a, v, load_n);
    const float load2 = vec_dot(load_n, load_n);
    if (!(given2 > HAPTABLE_NO_FORCE2 && load2 > HAPTABLE_NO_FORCE2)) return 0.0f;
    return load2 > given2 ? vec_inverse_root(given2 / load2 * vec_inverse_root(given2 / load2)) : 1.0f;
}

static void put_block(const float own[6], float by, float (*a)[ROWS], int at) {
    a[at][at] = by * own[0];
    a[at + 1][at + 1] = by * own[1];
    a[at + 2][at + 2] = by * own[2];
    a[at + 1][at] = by * own[3];
    a[at + 2][at + 1] = by * own[4];
    a[at + 2][at] = by * own[5];
}

/* C_21: X^T, or of a stiffness A_2^-1 X^T A_1^-1. */
static void put_cross(const struct haptable_pair_law* law, float c[HAPTABLE_FINGERS][6], const float x[9], float by,
                      float (*a)[ROWS]) {
    for (int i = 0; i < 3; ++i) {
        float unit[3] = {0.0f, 0.0f, 0.0f};
        float column[3]; /* of C_21 */
        unit[i] = 1.0f;
        if (law->is_stiffness) {
            float first[3];
            vec_symmetric_product(c[0], unit, first);
            mat_transposed_product(x, first, unit);
            vec_symmetric_product(c[1], unit, column);
        } else {
            mat_transposed_product(x, unit, column);
        }
        for (int j = 0; j < 3; ++j) a[3 + j][i] = by * column[j];
    }
}

/* Of two contacts of a tick that solved for both. */
static unsigned rows_of_both(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                             const struct haptable_past past[], float (*a)[ROWS]) {
    static const float none[6] = {1.0f, 1.0f, 1.0f, 0.0f, 0.0f, 0.0f};
    const struct haptable_contact* at[HAPTABLE_FINGERS] = {&pair->servo[0].contact, &pair->servo[1].contact};
    struct haptable_pair_own own[HAPTABLE_FINGERS];
    float c[HAPTABLE_FINGERS][6];
    float growth[HAPTABLE_FINGERS] = {0.0f, 0.0f};
    unsigned presses = 0;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        if (at[f]->patch == HAPTABLE_NONE || !pair->touches[f]) continue;
        tables->law->own(tables->model, at[f], pair->servo[f].finger_m, &own[f]);
        growth[f] = growth_of(tables->law, &own[f], pair->view[f].v, past[f].load_n);
        if (growth[f] > 0.0f) presses |= 1u << f;
        if (tables->law->is_stiffness) {
            sym_invert(own[f].a, c[f]);
        } else {
            vec_copy(&own[f].a[0], &c[f][0]);
            vec_copy(&own[f].a[3], &c[f][3]);
        }
    }
    if (presses == 3u) {
        float x[9];
        haptable_pair_tell(&pair->view[0], at[1], &own[1]);
        haptable_pair_cross_of_both(tables, pair, at[0], x);
        (void)haptable_pair_share(&pair->view[0], &own[0], x);
        put_cross(tables->law, c, x, growth[0] * growth[1], a);
    }
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        put_block((presses >> f & 1u) != 0u ? c[f] : none, (presses >> f & 1u) != 0u ? growth[f] * growth[f] : 1.0f, a,
                  3 * f);
    return presses;
}

unsigned haptable_rows_of_two(const struct haptable_scene* scene, void* state, const struct haptable_past past[],
                              float (*a)[ROWS]) {
    struct haptable_pair* pair = (struct haptable_pair*)state;
    unsigned presses = 0;
    for (int f = 0; f < 3; ++f) vec_zero(a[3 + f]);
    if (past[0].is_known && past[1].is_known) return rows_of_both(scene->pair, pair, past, a);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        if (haptable_rows_alone(scene->model, &pair->servo[f], f, past[f].load_n, a)) presses |= 1u << f;
    return presses;
}
