/* SPDX-License-Identifier: MIT
 *
 * [A_1 X; X^T A_2] v = s,   E = 1/2 s . v:   N v_1 = t,   N = A_1 - X A_2^-1 X^T,   t = s_1 - X A_2^-1 s_2
 *
 * dE/db = s_b . v_1 - 1/2 v_1^T A_b v_1 - v_1^T X_b v_2
 * d2E/db dc = v_1 . s_bc - 1/2 v_1^T A_bc v_1 - v_1^T X_bc v_2 + y_b^T N^-1 y_c + r_b^T A_2^-1 r_c
 * with r_b = -X_b^T v_1 and y_b = s_b - A_b v_1 - X_b v_2 - X A_2^-1 r_b: the last two terms are never negative.
 *
 * E is the energy of both over the place of the first, the second staying on the finger that holds it. What
 * haptable_pair.c and the force laws for two are made of: one file for each, so that each has it inlined.
 */
#ifndef HAPTABLE_PAIR_TERMS_H
#define HAPTABLE_PAIR_TERMS_H

#include "haptable_net.h"
#include "haptable_pair.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* ---- 3x3 matrices, row by row --------------------------------------------------------------------------------- */

static inline void pair_product(const float x[9], const float v[3], float out[3]) {
    out[0] = x[0] * v[0] + x[1] * v[1] + x[2] * v[2];
    out[1] = x[3] * v[0] + x[4] * v[1] + x[5] * v[2];
    out[2] = x[6] * v[0] + x[7] * v[1] + x[8] * v[2];
}

static inline void pair_transposed_product(const float x[9], const float v[3], float out[3]) {
    out[0] = x[0] * v[0] + x[3] * v[1] + x[6] * v[2];
    out[1] = x[1] * v[0] + x[4] * v[1] + x[7] * v[2];
    out[2] = x[2] * v[0] + x[5] * v[1] + x[8] * v[2];
}

/* out += w X and out = w X, as single statements, which compilers keep in registers. */
static inline void pair_add(float w, const float x[9], float out[9]) {
    out[0] += w * x[0];
    out[1] += w * x[1];
    out[2] += w * x[2];
    out[3] += w * x[3];
    out[4] += w * x[4];
    out[5] += w * x[5];
    out[6] += w * x[6];
    out[7] += w * x[7];
    out[8] += w * x[8];
}

static inline void pair_set(float w, const float x[9], float out[9]) {
    out[0] = w * x[0];
    out[1] = w * x[1];
    out[2] = w * x[2];
    out[3] = w * x[3];
    out[4] = w * x[4];
    out[5] = w * x[5];
    out[6] = w * x[6];
    out[7] = w * x[7];
    out[8] = w * x[8];
}

static inline void pair_copy(const float x[9], float out[9]) {
    vec_copy(&x[0], &out[0]);
    vec_copy(&x[3], &out[3]);
    vec_copy(&x[6], &out[6]);
}

static inline void pair_swap(float* a, float* b) {
    const float was = *a;
    *a = *b;
    *b = was;
}

static inline void pair_transpose(float x[9]) {
    pair_swap(&x[1], &x[3]);
    pair_swap(&x[2], &x[6]);
    pair_swap(&x[5], &x[7]);
}

/* The inverse of a symmetric positive definite matrix, by its cofactors. */
static inline void pair_invert(const float a[6], float inverse[6]) {
    const float xx = a[1] * a[2] - a[4] * a[4];
    const float xy = a[4] * a[5] - a[3] * a[2];
    const float zx = a[3] * a[4] - a[1] * a[5];
    const float scale = 1.0f / (a[0] * xx + a[3] * xy + a[5] * zx);
    inverse[0] = scale * xx;
    inverse[1] = scale * (a[0] * a[2] - a[5] * a[5]);
    inverse[2] = scale * (a[0] * a[1] - a[3] * a[3]);
    inverse[3] = scale * xy;
    inverse[4] = scale * (a[3] * a[5] - a[0] * a[4]);
    inverse[5] = scale * zx;
}

/* X M and a - X M X^T */
static inline void pair_reduce(const float a[6], const float x[9], const float m[6], float* restrict xm,
                               float* restrict n) {
    vec_symmetric_product(m, &x[0], &xm[0]); /* M is symmetric: a row of X M */
    vec_symmetric_product(m, &x[3], &xm[3]);
    vec_symmetric_product(m, &x[6], &xm[6]);
    n[0] = a[0] - vec_dot(&xm[0], &x[0]);
    n[1] = a[1] - vec_dot(&xm[3], &x[3]);
    n[2] = a[2] - vec_dot(&xm[6], &x[6]);
    n[3] = a[3] - vec_dot(&xm[0], &x[3]);
    n[4] = a[4] - vec_dot(&xm[3], &x[6]);
    n[5] = a[5] - vec_dot(&xm[6], &x[0]);
}

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

/* Over k, of blocks C_kl of so many controls each by k and then l; x is the first of the column. */
static inline void pair_sum_column(int count, const float w[], const float* x, float* restrict to) {
    if (count == HAPTABLE_PAIR_CONTROLS)
        pair_sum_six(w, x, (size_t)9 * HAPTABLE_PAIR_CONTROLS, to);
    else
        pair_sum_three(w, x, 27, to);
}

/* ---- places --------------------------------------------------------------------------------------------------- */

/* A finger's place with what its slope is made of. */
struct haptable_pair_point {
    struct haptable_pair_own own;
    float u[3];
    float e[2][3];      /* the patch's edges from corner 0 */
    struct reduced net; /* of a compliance, that of degree 2; the three S_a of a stiffness */
    float linear[3][6]; /* of a compliance, the net of degree 1 */
    uint8_t lifted;     /* 1: A's diagonal is lifted, as fixed vertices ask for it */
    uint8_t steps;      /* 1: the lift may begin or end here, and with it the load's slope steps */
};

/* How many controls a patch has. */
static inline int pair_count(const struct haptable_pair_law* law) {
    return law->controls == HAPTABLE_PAIR_CONTROLS ? HAPTABLE_PAIR_CONTROLS : 3;
}

/* The controls of a patch: its vertices, and under a mask the edges opposite to them, after all vertices. */
static inline void pair_controls(const struct haptable_pair_model* tables, uint16_t patch, uint16_t control[]) {
    const struct haptable_model* model = tables->model;
    const int is_mask = tables->law->controls == HAPTABLE_PAIR_CONTROLS;
    int c;
    for (c = 0; c < 3; ++c) {
        const uint16_t vertex = model->patch[patch][c];
        control[c] = is_mask || vertex < model->free_count ? vertex : HAPTABLE_NONE;
        if (is_mask) control[3 + c] = (uint16_t)(model->vertex_count + model->compliance->patch_edge[patch][c]);
    }
}

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
    felt_m[0] = x_m[0] + view->raised_m[0];
    felt_m[1] = x_m[1] + view->raised_m[1];
    felt_m[2] = x_m[2] + view->raised_m[2];
}

/* u of a finger whose dent begins elsewhere, to tell whether it presses: straight into its patch, of any length. */
static inline void pair_inwards(const struct haptable_model* model, uint16_t patch, float u[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    patch_frame(model, patch, edge1, edge2, normal);
    vec_zero(u);
    vec_sub(u, normal, u);
}

/* ---- how two places are coupled ------------------------------------------------------------------------------- */

/* What is left of the coupling, and how that changes with the place of the first: 1 where the fingers are apart. */
struct pair_meeting {
    int is_near;
    float share;
    float first[2];
    float second[3]; /* 11 12 22 */
};

static inline float pair_nearness(const struct haptable_pair_view* view, const float god_object_m[3]) {
    const float per_m = 1.0f / view->tables->meeting_m;
    return 1.0f - gap2(god_object_m, view->at_m) * per_m * per_m;
}

static inline float pair_share(const struct haptable_pair_view* view, const float god_object_m[3]) {
    const float near = pair_nearness(view, god_object_m);
    return near > 0.0f ? 1.0f - HAPTABLE_PAIR_MEETING * near * near : 1.0f;
}

/* e: the patch's edges from corner 0. */
static inline struct pair_meeting pair_meet(const struct haptable_pair_view* view, const float god_object_m[3],
                                            float e[2][3]) {
    struct pair_meeting meeting = {0, 1.0f, {0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    const float near = pair_nearness(view, god_object_m);
    const float scale = -2.0f / (view->tables->meeting_m * view->tables->meeting_m);
    float apart[3];
    float slope[2];
    if (near <= 0.0f) return meeting;
    meeting.is_near = 1;
    vec_sub(god_object_m, view->at_m, apart);
    slope[0] = scale * vec_dot(apart, e[0]); /* of near */
    slope[1] = scale * vec_dot(apart, e[1]);
    meeting.share = 1.0f - HAPTABLE_PAIR_MEETING * near * near;
    meeting.first[0] = -2.0f * HAPTABLE_PAIR_MEETING * near * slope[0];
    meeting.first[1] = -2.0f * HAPTABLE_PAIR_MEETING * near * slope[1];
    meeting.second[0] = -2.0f * HAPTABLE_PAIR_MEETING * (slope[0] * slope[0] + near * scale * vec_dot(e[0], e[0]));
    meeting.second[1] = -2.0f * HAPTABLE_PAIR_MEETING * (slope[0] * slope[1] + near * scale * vec_dot(e[0], e[1]));
    meeting.second[2] = -2.0f * HAPTABLE_PAIR_MEETING * (slope[1] * slope[1] + near * scale * vec_dot(e[1], e[1]));
    return meeting;
}

/* What was gathered before of a patch, or room for it, then without its patch. */
static inline struct haptable_pair_rows* pair_rows(const struct haptable_pair_view* view, uint16_t patch) {
    struct haptable_pair_rows* rows = (struct haptable_pair_rows*)view->rows; /* of a view, which is no constant */
    if (rows[0].patch != patch) ++rows;
    return rows;
}

/* The coupling of every control of a patch with the other's place. cost: as tables->cross, where it is not known */
static inline const struct haptable_pair_rows* pair_gather(const struct haptable_pair_view* view, uint16_t patch) {
    struct haptable_pair_rows* rows = pair_rows(view, patch);
    if (rows->patch == patch) return rows;
    if (view->rows[0].patch == HAPTABLE_NONE) rows = (struct haptable_pair_rows*)view->rows;
    rows->patch = patch;
    view->tables->cross(view, patch, rows->x);
    return rows;
}

/* The other finger has moved. */
static inline void pair_forget(struct haptable_pair_view* view) {
    view->rows[0].patch = view->rows[1].patch = HAPTABLE_NONE;
}

/* Where the other finger is. */
static inline void pair_look(const struct haptable_pair_model* tables, const struct haptable_contact* contact,
                             struct haptable_pair_view* view) {
    vec_copy(contact->god_object_m, view->at_m);
    view->place.patch = contact->patch;
    pair_controls(tables, contact->patch, view->place.control);
    pair_weights(pair_count(tables->law), contact->alpha, view->place.weight);
    pair_forget(view);
}

/* X of a contact. */
static inline void pair_cross(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                              float x[9]) {
    const struct haptable_pair_rows* rows = pair_gather(view, contact->patch);
    const float share = pair_share(view, contact->god_object_m);
    const int count = pair_count(view->tables->law);
    float weight[HAPTABLE_PAIR_CONTROLS];
    pair_weights(count, contact->alpha, weight);
    pair_sum(count, weight, rows->x[0], 9, x);
    if (share < 1.0f) pair_set(share, x, x);
}

/* The control of corners c and d of a mask's patch. */
static inline int pair_control_of(int c, int d) { return c == d ? c : 6 - c - d; }

/* x is, or else has, w dX by alpha_c under a mask, all alpha being free. */
static inline void pair_slope(const float (*control)[9], const float alpha[3], int c, float w, float x[9]) {
    int d;
    for (d = 0; d < 3; ++d) {
        const float share = 2.0f * w * alpha[d];
        if (w > 0.0f && d == 0)
            pair_set(share, control[pair_control_of(c, d)], x);
        else
            pair_add(share, control[pair_control_of(c, d)], x);
    }
}

/* X of a contact and its first derivatives by alpha_1, alpha_2; and v . X_bc w for the second. */
struct pair_coupling {
    float x[9];
    float first[2][9];
    const float (*control)[9];
    struct pair_meeting meeting;
};

static inline void pair_couple(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                               float e[2][3], struct pair_coupling* to) {
    const float* alpha = contact->alpha;
    float weight[HAPTABLE_PAIR_CONTROLS];
    const int count = pair_count(view->tables->law);
    float raw[9];
    int b;
    to->control = (const float(*)[9])pair_gather(view, contact->patch)->x;
    pair_weights(count, alpha, weight);
    to->meeting = pair_meet(view, contact->god_object_m, e);
    pair_sum(count, weight, to->control[0], 9, raw);
    pair_set(to->meeting.share, raw, to->x);
    for (b = 0; b < 2; ++b) {
        if (count == HAPTABLE_PAIR_CONTROLS) {
            pair_slope(to->control, alpha, b + 1, 1.0f, to->first[b]);
            pair_slope(to->control, alpha, 0, -1.0f, to->first[b]);
        } else {
            vec_sub(&to->control[b + 1][0], &to->control[0][0], &to->first[b][0]);
            vec_sub(&to->control[b + 1][3], &to->control[0][3], &to->first[b][3]);
            vec_sub(&to->control[b + 1][6], &to->control[0][6], &to->first[b][6]);
        }
        if (!to->meeting.is_near) continue;
        pair_set(to->meeting.share, to->first[b], to->first[b]);
        pair_add(to->meeting.first[b], raw, to->first[b]);
    }
}

/* The same of a share of X, which is taken as it is: X has it already. */
static inline void pair_fade(float share, struct pair_coupling* of) {
    int b;
    of->meeting.share *= share;
    for (b = 0; b < 2; ++b) {
        pair_set(share, of->first[b], of->first[b]);
        of->meeting.first[b] *= share;
    }
    for (b = 0; b < 3; ++b) of->meeting.second[b] *= share;
}

static inline float pair_bilinear(const float x[9], const float v[3], const float w[3]) {
    float xw[3];
    pair_product(x, w, xw);
    return vec_dot(v, xw);
}

/* v . X_bc w: 11 12 22. share X = X without the fingers' nearness, so that X_b holds share' of it already. */
static inline void pair_couple_twice(const struct haptable_pair_view* view, const struct pair_coupling* of,
                                     const float v[3], const float w[3], float second_j[3]) {
    const struct pair_meeting* m = &of->meeting;
    vec_zero(second_j);
    if (m->is_near) {
        const float x = pair_bilinear(of->x, v, w) / m->share; /* of the tables alone */
        const float x1 = (pair_bilinear(of->first[0], v, w) - m->first[0] * x) / m->share;
        const float x2 = (pair_bilinear(of->first[1], v, w) - m->first[1] * x) / m->share;
        second_j[0] = 2.0f * m->first[0] * x1 + m->second[0] * x;
        second_j[1] = m->first[0] * x2 + m->first[1] * x1 + m->second[1] * x;
        second_j[2] = 2.0f * m->first[1] * x2 + m->second[2] * x;
    }
    if (view->tables->law->controls == HAPTABLE_PAIR_CONTROLS) {
        float q[HAPTABLE_PAIR_CONTROLS];
        int k;
        for (k = 0; k < HAPTABLE_PAIR_CONTROLS; ++k) q[k] = 2.0f * m->share * pair_bilinear(of->control[k], v, w);
        second_j[0] += q[1] - 2.0f * q[pair_control_of(1, 0)] + q[0];
        second_j[1] += q[pair_control_of(1, 2)] - q[pair_control_of(1, 0)] - q[pair_control_of(2, 0)] + q[0];
        second_j[2] += q[2] - 2.0f * q[pair_control_of(2, 0)] + q[0];
    }
}

/* ---- the solve ------------------------------------------------------------------------------------------------ */

/* Both fingers' v, the first's place being given by its own terms and X. */
struct pair_solved {
    struct factored n;
    float v[3];     /* of the first */
    float other[3]; /* of the second */
    float t[3];
    float energy_j; /* 1/2 t . v_1: of both, less what the second stores alone */
};

/* v_2 = A_2^-1 (s_2 - X^T v_1) */
static inline void pair_other(const struct haptable_pair_view* view, const float x[9], const float v[3],
                              float other[3]) {
    float pressed[3];
    pair_transposed_product(x, v, pressed);
    vec_sub(view->s, pressed, pressed);
    vec_symmetric_product(view->m, pressed, other);
}

/* How much is left of each finger's compliance by itself, at the least: the mean of A_1^-1 N, which is that of
 * A_2^-1 N_2 too. */
#define HAPTABLE_PAIR_LEAST 0.015625f

/* Places that load one node alone, next to fixed ones, load it alike however far apart they are, and N is nothing. The
 * share of X that leaves HAPTABLE_PAIR_LEAST of it: 1, or less. It is of both fingers alike. */
static inline float pair_keep_definite(const float a[6], const float n[6]) {
    float inverse[6];
    float left;
    float share2;
    if (third_of_trace(n) > 3.0f * HAPTABLE_PAIR_LEAST * third_of_trace(a)) return 1.0f; /* most */
    pair_invert(a, inverse);
    left = (inverse[0] * n[0] + inverse[1] * n[1] + inverse[2] * n[2] +
            2.0f * (inverse[3] * n[3] + inverse[4] * n[4] + inverse[5] * n[5])) *
           (1.0f / 3.0f);
    if (left >= HAPTABLE_PAIR_LEAST) return 1.0f;
    share2 = (1.0f - HAPTABLE_PAIR_LEAST) / (1.0f - left);
    return share2 * vec_inverse_root(share2);
}

/* X A_2^-1 and N, of the share of X that keeps N definite: X becomes that. */
static inline float pair_reduce_definite(const float a[6], const float m[6], float x[9], float xm[9], float n[6]) {
    float share;
    pair_reduce(a, x, m, xm, n);
    share = pair_keep_definite(a, n);
    if (share < 1.0f) {
        pair_set(share, x, x);
        pair_reduce(a, x, m, xm, n);
    }
    return share;
}

/* v of the first, and t; X as pair_reduce_definite leaves it. Returns its share. */
static inline float pair_solve_place(const struct haptable_pair_view* view, const struct haptable_pair_own* own,
                                     float x[9], struct pair_solved* solved) {
    float n[6];
    float xm[9];
    const float share = pair_reduce_definite(own->a, view->m, x, xm, n);
    pair_product(x, view->alone, solved->t);
    vec_sub(own->s, solved->t, solved->t);
    solved->n = factor(n);
    solve(&solved->n, solved->t, solved->v);
    return share;
}

static inline float pair_solve(const struct haptable_pair_view* view, const struct haptable_pair_own* own, float x[9],
                               struct pair_solved* solved) {
    const float share = pair_solve_place(view, own, x, solved);
    pair_other(view, x, solved->v, solved->other);
    solved->energy_j = 0.5f * vec_dot(solved->t, solved->v);
    return share;
}

/* Curvature: hessian_j holds v . s_bc - 1/2 v A_bc v; y holds s_b - A_b v, and becomes N^-1 y. */
static inline void pair_bend(const struct haptable_pair_view* view, const struct pair_coupling* coupling,
                             const struct pair_solved* solved, float y[2][3], struct haptable_energy* energy) {
    float r[2][3];
    float mr[2][3];
    float z[2][3];
    float second_j[3];
    int b;
    pair_couple_twice(view, coupling, solved->v, solved->other, second_j);
    for (b = 0; b < 2; ++b) {
        float more[3];
        pair_transposed_product(coupling->first[b], solved->v, r[b]);
        vec_symmetric_product(view->m, r[b], mr[b]); /* of -r_b */
        pair_product(coupling->x, mr[b], more);
        vec_add_scaled(1.0f, more, y[b]);
        pair_product(coupling->first[b], solved->other, more);
        vec_sub(y[b], more, y[b]);
        solve(&solved->n, y[b], z[b]);
    }
    energy->gauss_newton_j[0] = vec_dot(y[0], z[0]) + vec_dot(r[0], mr[0]);
    energy->gauss_newton_j[1] = vec_dot(y[0], z[1]) + vec_dot(r[0], mr[1]);
    energy->gauss_newton_j[2] = vec_dot(y[1], z[1]) + vec_dot(r[1], mr[1]);
    for (b = 0; b < 3; ++b) energy->hessian_j[b] += energy->gauss_newton_j[b] - second_j[b];
    for (b = 0; b < 2; ++b) vec_copy(z[b], y[b]);
}

/* ---- both places at once --------------------------------------------------------------------------------------- */

/* The system of both places, solved. */
struct pair_system {
    float m[6];  /* A_2^-1 */
    float t[3];  /* s_1 - X A_2^-1 s_2 */
    float xm[9]; /* X A_2^-1 */
    struct factored n;
    float v[HAPTABLE_FINGERS][3];
    float alone[HAPTABLE_FINGERS][3]; /* v of each without the other */
    int lifted;                       /* 1: less of X was taken, so that N is definite */
    int touches[HAPTABLE_FINGERS];    /* 0: where the other alone presses, its dent leaves this one behind */
};

/* X of two contacts, apart or meeting. */
static inline void pair_cross_net(int count, const struct haptable_pair_net* net, const float first[],
                                  const float second[], float x[9]) {
    const float* block = net->block[0];
    int k = 0;
    do {
        float row[9];
        pair_sum(count, second, block, 9, row);
        if (k == 0)
            pair_set(first[0], row, x);
        else
            pair_add(first[k], row, x);
        block += 9 * (size_t)count;
    } while (++k < count);
}

/* The blocks between the patches of two contacts: read where one of them is another one than before. */
static inline const struct haptable_pair_net* pair_net(const struct haptable_pair_model* tables,
                                                       struct haptable_pair_net* net, uint16_t first, uint16_t second) {
    if (net->patch[0] == first && net->patch[1] == second) return net;
    net->patch[0] = first;
    net->patch[1] = second;
    tables->blocks(tables, first, second, net->block);
    return net;
}

/* X of two contacts. */
static inline void pair_cross_contacts(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                                       const struct haptable_contact* first, const struct haptable_contact* second,
                                       float x[9]) {
    const int count = pair_count(tables->law);
    const struct haptable_pair_net* net = pair_net(tables, &pair->net, first->patch, second->patch);
    const float near = 1.0f - gap2(first->god_object_m, second->god_object_m) / (tables->meeting_m * tables->meeting_m);
    float weight[HAPTABLE_FINGERS][HAPTABLE_PAIR_CONTROLS];
    pair_weights(count, first->alpha, weight[0]);
    pair_weights(count, second->alpha, weight[1]);
    pair_cross_net(count, net, weight[0], weight[1], x);
    if (near > 0.0f) pair_set(1.0f - HAPTABLE_PAIR_MEETING * near * near, x, x);
}

/* What each finger makes of the surface alone, A_2^-1 and t, and which fingers touch: one does unless u . q < 0.
 * dent: u and raised_m, which q is of. */
static inline void pair_press_alone(const struct haptable_pair_law* law, const struct haptable_pair_own* first,
                                    const struct haptable_pair_own* second, float u[HAPTABLE_FINGERS][3],
                                    float dent[HAPTABLE_FINGERS][3], const float x[9], struct pair_system* system) {
    const struct factored own = factor(first->a);
    float t[3];
    pair_invert(second->a, system->m);
    if (law->is_stiffness) {
        vec_copy(dent[0], system->alone[0]);
        vec_copy(dent[1], system->alone[1]);
    } else {
        solve(&own, first->s, system->alone[0]);
        vec_symmetric_product(system->m, second->s, system->alone[1]);
    }
    pair_product(x, system->alone[1], t);
    vec_sub(first->s, t, system->t);
    pair_transposed_product(x, system->alone[0], t);
    vec_sub(second->s, t, t);
    if (law->is_stiffness) { /* q = A^-1 t */
        float w[3];
        solve(&own, u[0], w);
        system->touches[0] = !(vec_dot(w, system->t) < 0.0f);
        vec_symmetric_product(system->m, u[1], w);
        system->touches[1] = !(vec_dot(w, t) < 0.0f);
    } else {
        system->touches[0] = !(vec_dot(u[0], system->t) < 0.0f);
        system->touches[1] = !(vec_dot(u[1], t) < 0.0f);
    }
}

/* X A_2^-1 and N = A_1 - X A_2^-1 X^T, factored; then both v. before: pair_press_alone. */
static inline void pair_press_both(const struct haptable_pair_own* first, const struct haptable_pair_own* second,
                                   float x[9], struct pair_system* system) {
    float n[6];
    float w[3];
    system->lifted = pair_reduce_definite(first->a, system->m, x, system->xm, n) < 1.0f;
    if (system->lifted) {
        float alone[3];
        vec_symmetric_product(system->m, second->s, alone);
        pair_product(x, alone, w);
        vec_sub(first->s, w, system->t);
    }
    system->n = factor(n);
    solve(&system->n, system->t, system->v[0]);
    pair_transposed_product(x, system->v[0], w);
    vec_sub(second->s, w, w);
    vec_symmetric_product(system->m, w, system->v[1]);
}

/* The one finger's own sensitivity is not known, but the god-object stays where its finger does. */
static inline void pair_keep_known(struct haptable_servo* servo) {
    vec_zero(servo->sensitivity_per_m[0]);
    vec_zero(servo->sensitivity_per_m[1]);
    servo->sensitivity_per_m[0][0] = 1e-12f;
}

/* A force ends where it is none: with least energy a finger that the other alone would leave behind touches while both
 * press on it, along u. It does not where the surface would have to be pulled there, wherever its god-object has gone;
 * of one that met the surface as it is at rest only if that presses on it without the other. */
static inline void pair_keep_pressing(const struct haptable_pair_model* tables, const float normal[3],
                                      const struct haptable_pair_own* own, int is_raised, const float u[3], int finger,
                                      struct pair_system* system) {
    float load[3];
    float alone[3];
    if (tables->law->is_stiffness) {
        vec_symmetric_product(own->a, system->v[finger], load);
        vec_symmetric_product(own->a, system->alone[finger], alone);
    } else {
        vec_copy(system->v[finger], load);
        vec_copy(system->alone[finger], alone);
    }
    if (vec_dot(u, load) >= 0.0f) system->touches[finger] = 1;
    if (vec_dot(normal, load) > 0.0f && (is_raised || vec_dot(normal, alone) < 0.0f)) system->touches[finger] = 0;
}

static inline const struct haptable_pair_view* pair_view_of(const struct haptable_model* model) {
    return (const struct haptable_pair_view*)model; /* the model is its first member */
}

#endif
