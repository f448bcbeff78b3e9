/* SPDX-License-Identifier: MIT
 *
 * [A_1 X; X^T A_2] v = s,   E = 1/2 s . v:   N v_1 = t,   N = A_1 - X A_2^-1 X^T,   t = s_1 - X A_2^-1 s_2
 *
 * dE/db = s_b . v_1 - 1/2 v_1^T A_b v_1 - v_1^T X_b v_2
 * d2E/db dc = v_1 . s_bc - 1/2 v_1^T A_bc v_1 - v_1^T X_bc v_2 + y_b^T N^-1 y_c + r_b^T A_2^-1 r_c
 * with r_b = -X_b^T v_1 and y_b = s_b - A_b v_1 - X_b v_2 - X A_2^-1 r_b: the last two terms are never negative.
 *
 * E is the energy of both over the place of the first, the second staying on the finger that holds it.
 */
#ifndef HAPTABLE_PAIR_TERMS_H
#define HAPTABLE_PAIR_TERMS_H

#include "haptable_matrix.h"
#include "haptable_pair.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* ---- sums of blocks -------------------------------------------------------------------------------------------- */

/* One number of three or six weighted blocks in a row, each `stride` numbers after the one before. */
static inline float pair_three(const float w[3], const float* x, size_t stride) {
    return w[0] * x[0] + w[1] * x[stride] + w[2] * x[2 * stride];
}

static inline float pair_six(const float w[6], const float* x, size_t stride) {
    return w[0] * x[0] + w[1] * x[stride] + w[2] * x[2 * stride] + w[3] * x[3 * stride] + w[4] * x[4 * stride] +
           w[5] * x[5 * stride];
}

/* Whole blocks, with every number a statement of its own: so the weights stay in registers. */
static inline void pair_sum_three(const float w[3], const float* x, size_t stride, float* restrict to) {
    to[0] = pair_three(w, &x[0], stride);
    to[1] = pair_three(w, &x[1], stride);
    to[2] = pair_three(w, &x[2], stride);
    to[3] = pair_three(w, &x[3], stride);
    to[4] = pair_three(w, &x[4], stride);
    to[5] = pair_three(w, &x[5], stride);
    to[6] = pair_three(w, &x[6], stride);
    to[7] = pair_three(w, &x[7], stride);
    to[8] = pair_three(w, &x[8], stride);
}

static inline void pair_sum_six(const float w[6], const float* x, size_t stride, float* restrict to) {
    to[0] = pair_six(w, &x[0], stride);
    to[1] = pair_six(w, &x[1], stride);
    to[2] = pair_six(w, &x[2], stride);
    to[3] = pair_six(w, &x[3], stride);
    to[4] = pair_six(w, &x[4], stride);
    to[5] = pair_six(w, &x[5], stride);
    to[6] = pair_six(w, &x[6], stride);
    to[7] = pair_six(w, &x[7], stride);
    to[8] = pair_six(w, &x[8], stride);
}

static inline void pair_sum(int count, const float w[], const float* x, size_t stride, float* restrict to) {
    if (count == HAPTABLE_PAIR_CONTROLS)
        pair_sum_six(w, x, stride, to);
    else
        pair_sum_three(w, x, stride, to);
}

/* ---- places --------------------------------------------------------------------------------------------------- */

/* How many controls a patch has. */
static inline int pair_count(const struct haptable_pair_law* law) {
    return law->controls == HAPTABLE_PAIR_CONTROLS ? HAPTABLE_PAIR_CONTROLS : 3;
}

/* The controls of a patch: its vertices, and under a mask the edges opposite to them, after all vertices. */
void haptable_pair_controls(const struct haptable_pair_model* tables, uint16_t patch, uint16_t control[]);

static inline void pair_weights(int count, const float alpha[3], float weight[]) {
    int c;
    vec_copy(alpha, weight);
    if (count != HAPTABLE_PAIR_CONTROLS) return;
    for (c = 0; c < 3; ++c) {
        weight[c] = alpha[c] * alpha[c];
        weight[3 + c] = 2.0f * alpha[next_corner(c)] * alpha[previous_corner(c)];
    }
}

/* Where a contact's dent ends. It begins where the finger met the surface, as the other had raised it. */
static inline void pair_felt(const struct haptable_pair_view* view, const float x_m[3], float felt_m[3]) {
    vec_add(x_m, view->raised_m, felt_m);
}

/* u of a finger whose dent begins elsewhere, to tell whether it presses: straight into its patch, of any length. */
void haptable_pair_inwards(const struct haptable_model* model, uint16_t patch, float u[3]);

/* ---- how two places are coupled ------------------------------------------------------------------------------- */

/* The coupling of every control of a patch with the other's place. cost: as tables->cross, where it is not known */
const struct haptable_pair_rows* haptable_pair_gather(const struct haptable_pair_view* view, uint16_t patch);

/* The other finger has moved. */
static inline void pair_forget(struct haptable_pair_view* view) {
    view->rows[0].patch = view->rows[1].patch = HAPTABLE_NONE;
}

/* Where the other finger is. */
void haptable_pair_look(const struct haptable_pair_model* tables, const struct haptable_contact* contact,
                        struct haptable_pair_view* view);

/* The control of corners c and d of a mask's patch. */
static inline int pair_control_of(int c, int d) { return c == d ? c : 6 - c - d; }

/* ---- the solve ------------------------------------------------------------------------------------------------ */

/* X A_2^-1 and N, of the share of X that keeps N definite: X becomes that. */
float haptable_pair_reduce_definite(const float a[6], const float m[6], float x[9], float xm[9], float n[6]);

/* force: of the pair at a contact of this finger's, the other being where it was told. Of those that a tick tries, as
 * friction does, nobody asks for the nodes' loads. */
haptable_force_fn haptable_pair_force;

/* ---- both places at once --------------------------------------------------------------------------------------- */

/* The system of both places, solved. */
struct pair_system {
    float m[6];  /* A_2^-1 */
    float t[3];  /* s_1 - X A_2^-1 s_2 */
    float xm[9]; /* X A_2^-1 */
    struct sym_factored n;
    float v[HAPTABLE_FINGERS][3];
    float alone[HAPTABLE_FINGERS][3]; /* v of each without the other */
    int lifted;                       /* 1: less of X was taken, so that N is definite */
    int touches[HAPTABLE_FINGERS];    /* 0: where the other alone presses, its dent leaves this one behind */
};

/* The blocks between the patches of two contacts: read where one of them is another one than before. */
const struct haptable_pair_net* haptable_pair_net_of(const struct haptable_pair_model* tables,
                                                     struct haptable_pair_net* net, uint16_t first, uint16_t second);

/* The rows of the patch where a finger is, from the blocks that the pair has of both patches. */
void haptable_pair_put_rows(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger);

/* X of two contacts. */
void haptable_pair_cross_contacts(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                                  const struct haptable_contact* first, const struct haptable_contact* second,
                                  float x[9]);

/* What each finger makes of the surface alone, A_2^-1 and t, and which fingers touch: one does unless u . q < 0.
 * dent: u and raised_m, which q is of. */
void haptable_pair_press_alone(const struct haptable_pair_law* law, const struct haptable_pair_own* first,
                               const struct haptable_pair_own* second, float u[HAPTABLE_FINGERS][3],
                               float dent[HAPTABLE_FINGERS][3], const float x[9], struct pair_system* system);

/* X A_2^-1 and N = A_1 - X A_2^-1 X^T, factored; then both v. before: pair_press_alone. */
void haptable_pair_press_both(const struct haptable_pair_own* first, const struct haptable_pair_own* second, float x[9],
                              struct pair_system* system);

/* A force ends where it is none: with least energy a finger that the other alone would leave behind touches while both
 * press on it, along u. It does not where the surface would have to be pulled there, wherever its god-object has gone;
 * of one that met the surface as it is at rest only if that presses on it without the other. */
void haptable_pair_keep_pressing(const struct haptable_pair_model* tables, const float normal[3],
                                 const struct haptable_pair_own* own, int is_raised, const float u[3], int finger,
                                 struct pair_system* system);

static inline const struct haptable_pair_view* pair_view_of(const struct haptable_model* model) {
    return (const struct haptable_pair_view*)model; /* the model is its first member */
}

#endif
