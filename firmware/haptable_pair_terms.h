/* SPDX-License-Identifier: MIT
 *
 * [A_1 X; X^T A_2] v = s,   E = 1/2 s . v,   X = share sum_kl w_k w_l C_kl of the controls of both places
 *
 * dE/dp = s_p . v - 1/2 v . A_p v,   d2E/dp dq = s_pq . v - 1/2 v . A_pq v + y_p . A^-1 y_q,   y_p = s_p - A_p v
 *
 * of area coordinates p, q of either place, A and y being of both. Solved by N v_1 = s_1 - X A_2^-1 s_2, N = A_1 - X
 * A_2^-1 X^T. Here 1 is the finger that is asked, and 2 the other, which its view tells of.
 */
#ifndef HAPTABLE_PAIR_TERMS_H
#define HAPTABLE_PAIR_TERMS_H

#include "haptable_matrix.h"
#include "haptable_pair.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* ---- sums over a patch's controls, of which there are 3 or 6 ----------------------------------------------------- */

static inline int pair_count(const struct haptable_pair_law* law) {
    return law->controls == HAPTABLE_PAIR_CONTROLS ? HAPTABLE_PAIR_CONTROLS : 3;
}

/* Sum of numbers, each `stride` after the one before. */
static inline float pair_sum_numbers(int count, const float w[], const float* x, size_t stride) {
    /* cppcheck-suppress uninitvar ; its caller fills count numbers */
    const float three = w[0] * x[0] + w[1] * x[stride] + w[2] * x[2 * stride];
    return count == 3 ? three : three + w[3] * x[3 * stride] + w[4] * x[4 * stride] + w[5] * x[5 * stride];
}

/* Of blocks of nine, each `stride` numbers after the one before. */
static inline void pair_sum_blocks(int count, const float w[], const float* x, size_t stride, float to[9]) {
    float sum[9]; /* in registers */
    mat_scale(w[0], x, sum);
    mat_add(w[1], x + stride, sum);
    mat_add(w[2], x + 2 * stride, sum);
    if (count != 3) {
        mat_add(w[3], x + 3 * stride, sum);
        mat_add(w[4], x + 4 * stride, sum);
        mat_add(w[5], x + 5 * stride, sum);
    }
    mat_copy(sum, to);
}

/* The controls of a patch: its vertices, and under a mask the edges opposite to them, after all vertices. */
void haptable_pair_controls(const struct haptable_pair_model* tables, uint16_t patch, uint16_t control[]);

/* Where a contact is, and what it loads there. */
void haptable_pair_place_of(const struct haptable_pair_law* law, const struct haptable_contact* contact,
                            struct haptable_pair_place* place);

/* sum_k dw_k/db q_k by its alpha_1 and alpha_2, which is added. */
void haptable_pair_add_slope(const struct haptable_pair_law* law, const struct haptable_contact* contact,
                             const float q[HAPTABLE_PAIR_CONTROLS], float slope[2]);

/* ---- what a finger is told of the other ------------------------------------------------------------------------- */

/* Where a contact's dent ends. It begins where the finger met the surface, as the other had raised it. */
static inline void pair_felt(const struct haptable_pair_view* view, const float x_m[3], float felt_m[3]) {
    vec_add(x_m, view->raised_m, felt_m);
}

static inline int pair_is_raised(const struct haptable_pair_view* view) {
    return vec_dot(view->raised_m, view->raised_m) > 0.0f;
}

/* The load of v on the surface, N. */
void haptable_pair_load_of(const struct haptable_pair_law* law, const float a[6], const float v[3], float load_n[3]);

/* Of the other finger: its contact, and its own terms there. */
void haptable_pair_tell(struct haptable_pair_view* view, const struct haptable_contact* contact,
                        const struct haptable_pair_own* own);

/* The blocks between two patches: read where one of them is another one than before. */
void haptable_pair_read(const struct haptable_pair_model* tables, struct haptable_pair_net* net, uint16_t first,
                        uint16_t second);

/* 1 where reading the blocks of two patches takes many times as long as a place's rows, and they are not read. */
static inline int pair_is_dear(const struct haptable_pair_model* tables, const struct haptable_pair_net* net,
                               uint16_t first, uint16_t second) {
    return tables->place_count > 0 && !(net->is_read && net->patch[0] == first && net->patch[1] == second);
}

/* What couples a finger's patch to the other's place, from the blocks of both patches where these are not dear. before:
 * haptable_pair_tell. */
void haptable_pair_put_rows(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                            uint16_t patch);

/* ---- how two places are coupled --------------------------------------------------------------------------------- */

/* X, and how it changes with a finger's alpha_1, alpha_2, b. */
struct pair_link {
    const struct haptable_pair_law* law;
    const float (*row)[9]; /* of each of the patch's controls: sum_l w_l C_kl */
    float weight[HAPTABLE_PAIR_CONTROLS];
    float slope[2][HAPTABLE_PAIR_CONTROLS]; /* dw_k / db */
    float share;                            /* of the coupling: 1, or less where fingers meet or N is lifted */
    float share_slope[2];
    float share_bend[3]; /* 11 12 22 */
    float near;          /* 1 - r^2 / meeting_m^2, r apart; above 0 they meet */
    float near_slope[2];
};

/* e: edges of the patch from its corner 0, m; NULL: no slopes. */
void haptable_pair_link(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                        const float (*row)[9], float (*e)[3], struct pair_link* link);

static inline void pair_cross_of(const struct pair_link* link, float x[9]) {
    pair_sum_blocks(pair_count(link->law), link->weight, link->row[0], 9, x);
    if (link->share < 1.0f) mat_scale(link->share, x, x);
}

/* X of a finger that is told of the other. */
void haptable_pair_cross(const struct haptable_pair_view* view, const struct haptable_contact* contact, float x[9]);

/* X of two contacts that were told of each other, from the blocks of both patches. */
void haptable_pair_cross_of_both(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                                 const struct haptable_contact* first, float x[9]);

/* X v of a finger, X being the first's, where the other presses alone. */
void haptable_pair_pressed(const struct haptable_pair_view* view, int finger, const float x[9], float pressed[3]);

/* v . X_b v_other, by q_k = v . x_k v_other of the controls. */
static inline void pair_coupled_slope(int count, const struct pair_link* link, const float q[], float coupled_j[2]) {
    for (int b = 0; b < 2; ++b) coupled_j[b] = link->share * pair_sum_numbers(count, link->slope[b], q, 1);
    if (link->share < 1.0f) {
        const float whole_j = pair_sum_numbers(count, link->weight, q, 1);
        for (int b = 0; b < 2; ++b) coupled_j[b] += link->share_slope[b] * whole_j;
    }
}

/* What coupling makes of slopes by a finger's coordinates, both fingers' v being given. */
struct pair_varied {
    float back[2][3];   /* X_b^T v: what the other's y is less by */
    float coupled_j[3]; /* v . R_b v_other, and v . R v_other where share < 1; X = share R */
};

/* Takes it off the slopes that the place has by itself. */
void haptable_pair_vary(const struct pair_link* link, const float v[3], const float other[3],
                        struct haptable_pair_slope* slope, struct pair_varied* varied);

/* ---- the solve -------------------------------------------------------------------------------------------------- */

/* Of both places; the first is the finger's that is asked. */
struct pair_system {
    float xm[9]; /* X A_2^-1 */
    struct sym_factored n;
    float t[3]; /* s_1 - X A_2^-1 s_2 */
    float v[HAPTABLE_FINGERS][3];
};

/* Returns the share of X that keeps N definite, 1 or less; X becomes that. */
float haptable_pair_share(const struct haptable_pair_view* view, const struct haptable_pair_own* own, float x[9]);

/* Both v, by that share. */
float haptable_pair_solve(const struct haptable_pair_view* view, const struct haptable_pair_own* own, float x[9],
                          struct pair_system* system);

/* [A_1 X; X^T A_2] z = y */
static inline void pair_solve_slope(const struct haptable_pair_view* view, const struct pair_system* system,
                                    float y[HAPTABLE_FINGERS][3], float z[HAPTABLE_FINGERS][3]) {
    float t[3];
    mat_product(system->xm, y[1], t);
    vec_sub(y[0], t, t);
    sym_solve(&system->n, t, z[0]);
    vec_symmetric_product(view->m, y[1], z[1]);
    mat_transposed_product(system->xm, z[0], t);
    vec_sub(z[1], t, z[1]);
}

/* u, to tell whether a finger presses: straight into its patch, of any length, where its dent begins elsewhere. */
void haptable_pair_inwards(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                           const float x_m[3], float u[3]);

/* Which fingers touch of two that were told of each other. One does unless u . q < 0 with q what its dent lacks while
 * the other alone presses. With least energy it also does where both press along u, and does not where the surface
 * would have to be pulled, wherever its god-object has gone: if it met the surface as that is at rest, only where it
 * presses without the other. X is of the first; v: both fingers'. */
void haptable_pair_touch(const struct haptable_pair* pair, const struct haptable_contact* const at[HAPTABLE_FINGERS],
                         const float* const x_m[HAPTABLE_FINGERS],
                         const struct haptable_pair_own* const own[HAPTABLE_FINGERS], const float x[9],
                         float v[HAPTABLE_FINGERS][3], int touches[HAPTABLE_FINGERS]);

/* force: of the pair at a contact of this finger's, the other being where it was told. Of those that a tick tries, as
 * friction does, nobody asks for the nodes' loads. */
haptable_force_fn haptable_pair_force;

static inline const struct haptable_pair_view* pair_view_of(const struct haptable_model* model) {
    return (const struct haptable_pair_view*)model; /* the model is its first member */
}

#endif
