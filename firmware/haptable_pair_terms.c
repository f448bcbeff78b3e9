/* SPDX-License-Identifier: MIT
 *
 * X and its slopes, N = A_1 - X A_2^-1 X^T, and the force and energy of the pair: haptable_pair_terms.h
 */
#include "haptable_pair_terms.h"

void haptable_pair_controls(const struct haptable_pair_model* tables, uint16_t patch, uint16_t control[]) {
    const struct haptable_model* model = tables->model;
    const int is_mask = tables->law->controls == HAPTABLE_PAIR_CONTROLS;
    for (int c = 0; c < 3; ++c) {
        const uint16_t vertex = model->patch[patch][c];
        control[c] = is_mask || vertex < model->free_count ? vertex : HAPTABLE_NONE;
        if (is_mask) control[3 + c] = (uint16_t)(model->vertex_count + model->compliance->patch_edge[patch][c]);
    }
}

static inline void put_weights(int count, const float alpha[3], float weight[]) {
    vec_copy(alpha, weight);
    if (count == 3) return;
    for (int c = 0; c < 3; ++c) {
        weight[c] = alpha[c] * alpha[c];
        weight[3 + c] = 2.0f * alpha[next_corner(c)] * alpha[previous_corner(c)];
    }
}

void haptable_pair_place_of(const struct haptable_pair_law* law, const struct haptable_contact* contact,
                            struct haptable_pair_place* to) {
    to->patch = contact->patch;
    put_weights(pair_count(law), contact->alpha, to->weight);
}

static inline void put_slope_weights(int count, const float alpha[3], float slope[2][HAPTABLE_PAIR_CONTROLS]) {
    if (count == 3) {
        slope[0][0] = slope[1][0] = -1.0f;
        slope[0][1] = slope[1][2] = 1.0f;
        slope[0][2] = slope[1][1] = 0.0f;
        return;
    }
    for (int b = 0; b < 2; ++b) { /* of a mask: corners, then the edges opposite to them */
        const int c = b + 1;
        const int d = 2 - b;
        slope[b][0] = -2.0f * alpha[0];
        slope[b][c] = 2.0f * alpha[c];
        slope[b][d] = 0.0f;
        slope[b][3] = 2.0f * alpha[d];
        slope[b][3 + c] = -2.0f * alpha[d];
        slope[b][3 + d] = 2.0f * (alpha[0] - alpha[c]);
    }
}

void haptable_pair_add_slope(const struct haptable_pair_law* law, const struct haptable_contact* contact,
                             const float q[HAPTABLE_PAIR_CONTROLS], float to[2]) {
    float slope[2][HAPTABLE_PAIR_CONTROLS];
    put_slope_weights(pair_count(law), contact->alpha, slope);
    for (int b = 0; b < 2; ++b) to[b] += pair_sum_numbers(pair_count(law), slope[b], q, 1);
}

void haptable_pair_load_of(const struct haptable_pair_law* law, const float a[6], const float v[3], float load_n[3]) {
    if (law->is_stiffness)
        vec_symmetric_product(a, v, load_n);
    else
        vec_copy(v, load_n);
}

/* ---- what a finger is told of the other ------------------------------------------------------------------------- */

void haptable_pair_tell(struct haptable_pair_view* view, const struct haptable_contact* contact,
                        const struct haptable_pair_own* own) {
    sym_invert(own->a, view->m);
    vec_copy(own->s, view->s);
    vec_symmetric_product(view->m, own->s, view->alone);
    vec_copy(contact->god_object_m, view->at_m);
    view->place.patch = contact->patch;
    put_weights(pair_count(view->tables->law), contact->alpha, view->place.weight);
    view->rows[0].patch = view->rows[1].patch = HAPTABLE_NONE;
    view->is_coupled = 1;
    view->share = 1.0f;
}

void haptable_pair_read(const struct haptable_pair_model* tables, struct haptable_pair_net* net, uint16_t first,
                        uint16_t second) {
    if (net->is_read && net->patch[0] == first && net->patch[1] == second) return;
    net->patch[0] = first;
    net->patch[1] = second;
    net->is_read = 1;
    tables->blocks(tables, first, second, net->block);
}

/* Of the first finger from blocks in rows of so many, of the second from their columns. */
static inline void sum_others(int count, int finger, const float weight[], const float (*block)[9], float (*x)[9]) {
    for (int k = 0; k < count; ++k) {
        if (finger == 0) {
            pair_sum_blocks(count, weight, block[k * count], 9, x[k]);
        } else {
            pair_sum_blocks(count, weight, block[k], 9 * (size_t)count, x[k]);
            mat_transpose(x[k]);
        }
    }
}

void haptable_pair_put_rows(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                            uint16_t patch) {
    struct haptable_pair_view* view = &pair->view[finger];
    const uint16_t first = finger == 0 ? patch : view->place.patch;
    const uint16_t second = finger == 0 ? view->place.patch : patch;
    const float(*block)[9] = (const float(*)[9])pair->net.block;
    view->rows[0].patch = patch;
    if (pair_is_dear(tables, &pair->net, first, second)) {
        tables->cross(view, patch, view->rows[0].x);
        return;
    }
    haptable_pair_read(tables, &pair->net, first, second);
    if (pair_count(tables->law) == 3)
        sum_others(3, finger, view->place.weight, block, view->rows[0].x);
    else
        sum_others(HAPTABLE_PAIR_CONTROLS, finger, view->place.weight, block, view->rows[0].x);
}

/* The rows of a patch: of the finger's own, as they were put; or of another one, kept until that is a third. */
static inline const struct haptable_pair_rows* rows_of(const struct haptable_pair_view* view, uint16_t patch) {
    struct haptable_pair_rows* rows = (struct haptable_pair_rows*)view->rows; /* of a view, which is no constant */
    if (rows[0].patch == patch) return &rows[0];
    if (rows[1].patch != patch) {
        rows[1].patch = patch;
        view->tables->cross(view, patch, rows[1].x);
    }
    return &rows[1];
}

/* ---- how two places are coupled --------------------------------------------------------------------------------- */

/* Of fingers that meet: share = 1 - HAPTABLE_PAIR_MEETING near^2, with its derivatives by this one's coordinates. */
static void put_share_slopes(const struct haptable_pair_view* view, const float apart_m[3], float e[2][3],
                             struct pair_link* link) {
    const float by = -2.0f * HAPTABLE_PAIR_MEETING;
    const float scale = -2.0f / (view->tables->meeting_m * view->tables->meeting_m);
    float* slope = link->near_slope;
    for (int b = 0; b < 2; ++b) {
        slope[b] = scale * vec_dot(apart_m, e[b]);
        link->share_slope[b] = by * link->near * slope[b];
    }
    link->share_bend[0] = by * (slope[0] * slope[0] + link->near * scale * vec_dot(e[0], e[0]));
    link->share_bend[1] = by * (slope[0] * slope[1] + link->near * scale * vec_dot(e[0], e[1]));
    link->share_bend[2] = by * (slope[1] * slope[1] + link->near * scale * vec_dot(e[1], e[1]));
}

void haptable_pair_link(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                        const float (*row)[9], float (*e)[3], struct pair_link* link) {
    const int count = pair_count(view->tables->law);
    const float per_m = 1.0f / view->tables->meeting_m;
    float apart_m[3];
    link->law = view->tables->law;
    link->row = row;
    put_weights(count, contact->alpha, link->weight);
    vec_sub(contact->god_object_m, view->at_m, apart_m);
    link->near = 1.0f - vec_dot(apart_m, apart_m) * per_m * per_m;
    link->share = link->near > 0.0f ? 1.0f - HAPTABLE_PAIR_MEETING * link->near * link->near : 1.0f;
    if (!e) return;
    link->share_slope[0] = link->share_slope[1] = 0.0f;
    vec_zero(link->share_bend);
    put_slope_weights(count, contact->alpha, link->slope);
    if (link->near > 0.0f) put_share_slopes(view, apart_m, e, link);
}

void haptable_pair_cross(const struct haptable_pair_view* view, const struct haptable_contact* contact, float x[9]) {
    struct pair_link link;
    haptable_pair_link(view, contact, (const float(*)[9])rows_of(view, contact->patch)->x, 0, &link);
    pair_cross_of(&link, x);
}

/* sum_k w_k sum_l w_l C_kl, a row at a time, which stays in registers. */
static inline void sum_rows(int count, const float first[], const float second[], const float (*block)[9], float x[9]) {
    float sum[9] = {0.0f};
    for (int k = 0; k < count; ++k) {
        float row[9];
        pair_sum_blocks(count, second, block[k * count], 9, row);
        mat_add(first[k], row, sum);
    }
    mat_copy(sum, x);
}

void haptable_pair_cross_of_both(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                                 const struct haptable_contact* first, float x[9]) {
    const struct haptable_pair_view* view = &pair->view[0];
    const uint16_t second = view->place.patch;
    struct haptable_pair_net* net = &pair->net;
    struct pair_link link;
    if (pair_is_dear(tables, net, first->patch, second) && (net->patch[0] != first->patch || net->patch[1] != second)) {
        net->patch[0] = first->patch;
        net->patch[1] = second;
        net->is_read = 0;
        haptable_pair_cross(view, first, x);
        return;
    }
    haptable_pair_read(tables, net, first->patch, second);
    haptable_pair_link(view, first, 0, 0, &link);
    if (pair_count(link.law) == 3)
        sum_rows(3, link.weight, view->place.weight, (const float(*)[9])net->block, x);
    else
        sum_rows(HAPTABLE_PAIR_CONTROLS, link.weight, view->place.weight, (const float(*)[9])net->block, x);
    if (link.share < 1.0f) mat_scale(link.share, x, x);
}

void haptable_pair_pressed(const struct haptable_pair_view* view, int finger, const float x[9], float pressed[3]) {
    if (finger == 0)
        mat_product(x, view->alone, pressed);
    else
        mat_transposed_product(x, view->alone, pressed);
}

/* A share of X, as the solve took it. */
static void take_share(float share, struct pair_link* link) {
    link->share *= share;
    for (int b = 0; b < 2; ++b) link->share_slope[b] *= share;
    for (int b = 0; b < 3; ++b) link->share_bend[b] *= share;
}

/* q_bc of a mask, whose weights are quadratic, 11 12 22: q_k of its corners, then of the edges opposite to them. */
static void put_bend(const float q[HAPTABLE_PAIR_CONTROLS], float bend_j[3]) {
    bend_j[0] = 2.0f * (q[1] - 2.0f * q[5] + q[0]);
    bend_j[1] = 2.0f * (q[3] - q[5] - q[4] + q[0]);
    bend_j[2] = 2.0f * (q[2] - 2.0f * q[4] + q[0]);
}

static inline void sum_vectors(int count, const float w[], float (*x)[3], float to[3]) {
    to[0] = pair_sum_numbers(count, w, &x[0][0], 3);
    to[1] = pair_sum_numbers(count, w, &x[0][1], 3);
    to[2] = pair_sum_numbers(count, w, &x[0][2], 3);
}

/* The same of X = share R from that of R. */
static void vary_share(int count, const struct pair_link* link, const float v[3], float by[][3], float from[][3],
                       float x_v[2][3], struct pair_varied* varied, float bend_j[3]) {
    const float* slope = link->share_slope;
    float* r = varied->coupled_j;
    float r_v[3];  /* R v_other */
    float back[3]; /* R^T v */
    sum_vectors(count, link->weight, by, r_v);
    sum_vectors(count, link->weight, from, back);
    r[2] = vec_dot(v, r_v);
    bend_j[0] = link->share * bend_j[0] + 2.0f * slope[0] * r[0] + link->share_bend[0] * r[2];
    bend_j[1] = link->share * bend_j[1] + slope[0] * r[1] + slope[1] * r[0] + link->share_bend[1] * r[2];
    bend_j[2] = link->share * bend_j[2] + 2.0f * slope[1] * r[1] + link->share_bend[2] * r[2];
    for (int b = 0; b < 2; ++b) {
        for (int a = 0; a < 3; ++a) {
            x_v[b][a] = link->share * x_v[b][a] + slope[b] * r_v[a];
            varied->back[b][a] = link->share * varied->back[b][a] + slope[b] * back[a];
        }
    }
}

void haptable_pair_vary(const struct pair_link* link, const float v[3], const float other[3],
                        struct haptable_pair_slope* slope, struct pair_varied* varied) {
    const int count = pair_count(link->law);
    float by[HAPTABLE_PAIR_CONTROLS][3];   /* x_k v_other */
    float from[HAPTABLE_PAIR_CONTROLS][3]; /* x_k^T v */
    float bend_j[3] = {0.0f, 0.0f, 0.0f};
    float x_v[2][3];
    for (int k = 0; k < count; ++k) {
        mat_product(link->row[k], other, by[k]);
        mat_transposed_product(link->row[k], v, from[k]);
    }
    for (int b = 0; b < 2; ++b) {
        sum_vectors(count, link->slope[b], by, x_v[b]);
        sum_vectors(count, link->slope[b], from,
                    varied->back[b]); /* cppcheck-suppress uninitvar ; it is written here */
        varied->coupled_j[b] = vec_dot(v, x_v[b]);
    }
    if (count == HAPTABLE_PAIR_CONTROLS) {
        float q[HAPTABLE_PAIR_CONTROLS];
        for (int k = 0; k < HAPTABLE_PAIR_CONTROLS; ++k) q[k] = vec_dot(v, by[k]);
        put_bend(q, bend_j);
    }
    if (link->share < 1.0f) vary_share(count, link, v, by, from, x_v, varied, bend_j);
    for (int b = 0; b < 2; ++b) {
        vec_sub(slope->y[b], x_v[b], slope->y[b]);
        slope->first_j[b] -= vec_dot(v, x_v[b]);
    }
    vec_sub(slope->second_j, bend_j, slope->second_j);
}

/* ---- the solve -------------------------------------------------------------------------------------------------- */

/* How much is left of each finger's compliance by itself, at the least: the mean of A_1^-1 N, which is that of
 * A_2^-1 N_2 too. */
#define LEAST_OWN 0.015625f

/* Places that load one node alone, next to fixed ones, load it alike however far apart they are, and N is nothing.
 * Takes the share of X that leaves LEAST_OWN of it: 1, or less. It is of both fingers alike. */
static float keep_definite(const float a[6], const float m[6], float x[9], float xm[9], float n[6]) {
    float inverse[6];
    sym_invert(a, inverse);
    const float left = (inverse[0] * n[0] + inverse[1] * n[1] + inverse[2] * n[2] +
                        2.0f * (inverse[3] * n[3] + inverse[4] * n[4] + inverse[5] * n[5])) *
                       (1.0f / 3.0f);
    if (left >= LEAST_OWN) return 1.0f;
    float share = (1.0f - LEAST_OWN) / (1.0f - left); /* squared */
    share *= vec_inverse_root(share);
    if (share < 1.0f) {
        mat_scale(share, x, x);
        sym_reduce(a, x, m, xm, n);
    }
    return share;
}

/* v_2 = A_2^-1 (s_2 - X^T v_1) */
static inline void put_other(const struct haptable_pair_view* view, const float x[9], const float v[3],
                             float other[3]) {
    float pressed[3];
    mat_transposed_product(x, v, pressed);
    vec_sub(view->s, pressed, pressed);
    vec_symmetric_product(view->m, pressed, other);
}

static inline float take_definite(const struct haptable_pair_view* view, const struct haptable_pair_own* own,
                                  float x[9], float xm[9], float n[6]) {
    sym_reduce(own->a, x, view->m, xm, n);
    if (sym_third_of_trace(n) > 3.0f * LEAST_OWN * sym_third_of_trace(own->a)) return 1.0f;
    return keep_definite(own->a, view->m, x, xm, n);
}

float haptable_pair_share(const struct haptable_pair_view* view, const struct haptable_pair_own* own, float x[9]) {
    float xm[9], n[6];
    return take_definite(view, own, x, xm, n);
}

float haptable_pair_solve(const struct haptable_pair_view* view, const struct haptable_pair_own* own, float x[9],
                          struct pair_system* system) {
    float n[6];
    const float share = take_definite(view, own, x, system->xm, n);
    mat_product(x, view->alone, system->t);
    vec_sub(own->s, system->t, system->t);
    system->n = sym_factor(n);
    sym_solve(&system->n, system->t, system->v[0]);
    put_other(view, x, system->v[0], system->v[1]);
    return share;
}

/* ---- which fingers touch ---------------------------------------------------------------------------------------- */

/* Of u . s: less of it is rounding, where both load one node next to fixed ones and q = 0. */
#define NO_DENT 0x1p-16f

void haptable_pair_inwards(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                           const float x_m[3], float u[3]) {
    float edge[2][3], normal[3];
    vec_sub(x_m, contact->god_object_m, u);
    if (!pair_is_raised(view)) return;
    patch_frame(&view->model, contact->patch, edge[0], edge[1], normal);
    vec_zero(u);
    vec_sub(u, normal, u);
}

void haptable_pair_touch(const struct haptable_pair* pair, const struct haptable_contact* const at[HAPTABLE_FINGERS],
                         const float* const x_m[HAPTABLE_FINGERS],
                         const struct haptable_pair_own* const own[HAPTABLE_FINGERS], const float x[9],
                         float v[HAPTABLE_FINGERS][3], int touches[HAPTABLE_FINGERS]) {
    const struct haptable_pair_model* tables = pair->view[0].tables;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        const struct haptable_pair_view* other = &pair->view[1 - f]; /* it is told of this one */
        const int is_raised = pair_is_raised(&pair->view[f]);
        float edge[2][3], normal[3], u[3], w[3], t[3];
        haptable_pair_inwards(&pair->view[f], at[f], x_m[f], u);
        haptable_pair_pressed(&pair->view[f], f, x, t);
        vec_sub(own[f]->s, t, t);
        vec_copy(u, w);
        if (tables->law->is_stiffness) vec_symmetric_product(other->m, u, w); /* q = A^-1 t */
        const float dented = vec_dot(w, t);
        const float least = NO_DENT * vec_magnitude(vec_dot(w, own[f]->s));
        touches[f] = !(dented < -least);
        if (!tables->energy) continue;
        patch_frame(tables->model, at[f]->patch, edge[0], edge[1], normal);
        haptable_pair_load_of(tables->law, own[f]->a, v[f], w);
        haptable_pair_load_of(tables->law, own[f]->a, other->alone, t);
        if (vec_dot(u, w) >= 0.0f) touches[f] = 1;
        if (vec_dot(normal, w) > 0.0f && (is_raised || vec_dot(normal, t) < 0.0f)) touches[f] = 0;
    }
}

/* ---- the force -------------------------------------------------------------------------------------------------- */

void haptable_pair_force(const struct haptable_model* model, const struct haptable_contact* contact,
                         const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    const struct haptable_pair_view* view = pair_view_of(model);
    const struct haptable_pair_law* law = view->tables->law;
    struct haptable_pair_own own;
    struct pair_system system;
    float felt_m[3], load_n[3];
    if (view->is_solved) {
        law->load(model, contact, view->v, nodal_force_n, force_n);
        return;
    }
    pair_felt(view, finger_m, felt_m);
    law->own(model, contact, felt_m, &own);
    if (view->is_coupled) {
        float x[9];
        haptable_pair_cross(view, contact, x);
        (void)haptable_pair_solve(view, &own, x, &system);
        haptable_pair_load_of(law, own.a, system.v[0], load_n);
    } else if (law->is_stiffness) {
        vec_copy(own.s, load_n);
    } else {
        system.n = sym_factor(own.a);
        sym_solve(&system.n, own.s, load_n);
    }
    vec_zero(force_n);
    vec_sub(force_n, load_n, force_n);
}

/* ---- the energy ------------------------------------------------------------------------------------------------- */

/* y_p . A^-1 y_q, and how v changes, z. */
static void put_gauss_newton(const struct haptable_pair_view* view, const struct pair_system* system,
                             struct haptable_pair_slope* slope, const struct pair_varied* varied,
                             float gauss_newton_j[3]) {
    float y[2][HAPTABLE_FINGERS][3], z[2][HAPTABLE_FINGERS][3];
    for (int b = 0; b < 2; ++b) {
        vec_copy(slope->y[b], y[b][0]);
        vec_zero(y[b][1]);
        vec_sub(y[b][1], varied->back[b], y[b][1]);
        pair_solve_slope(view, system, y[b], z[b]);
        vec_copy(z[b][0], slope->y[b]);
    }
    for (int b = 0; b < 3; ++b) { /* 11 12 22 */
        const int p = b == 2 ? 1 : 0;
        const int q = b == 0 ? 0 : 1;
        gauss_newton_j[b] = vec_dot(y[p][0], z[q][0]) + vec_dot(y[p][1], z[q][1]);
    }
}

/* The load's slope is v's, or A_b v + A v_b; none where it steps. */
static void put_load_slope(const struct haptable_pair_law* law, const struct haptable_pair_point* point,
                           struct haptable_pair_slope* slope, float load_gradient_n[2][3]) {
    for (int b = 0; b < 2; ++b) {
        haptable_pair_load_of(law, point->own.a, slope->y[b], load_gradient_n[b]);
        if (law->is_stiffness) vec_add_scaled(1.0f, slope->a_v[b], load_gradient_n[b]);
        if (point->steps) vec_no_number(load_gradient_n[b]);
    }
}

/* E of both over the place of the one, the other staying. */
static void put_energy(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                       const float felt_m[3], enum haptable_energy_terms terms, struct haptable_energy* energy) {
    const struct haptable_pair_model* tables = view->tables;
    struct haptable_pair_slope slope;
    struct haptable_pair_point point;
    struct pair_system system;
    struct pair_link link;
    struct pair_varied varied;
    float x[9];
    tables->bend->open(tables->model, contact, felt_m, &point);
    haptable_pair_link(view, contact, (const float(*)[9])rows_of(view, contact->patch)->x, point.e, &link);
    pair_cross_of(&link, x);
    if (terms == HAPTABLE_ENERGY_GRADIENT && !tables->law->is_stiffness) { /* v is the load, which is known */
        vec_copy(energy->load_n, system.v[0]);                /* cppcheck-suppress uninitvar ; it is written here */
        if (view->share < 1.0f) mat_scale(view->share, x, x); /* the same place as another patch sees it */
        put_other(view, x, system.v[0], system.v[1]);
    } else {
        struct haptable_pair_view* told = (struct haptable_pair_view*)view; /* of a model, which is no constant */
        told->share = haptable_pair_solve(view, &point.own, x, &system);
        energy->energy_j = 0.5f * vec_dot(system.t, system.v[0]); /* of both, less what the other stores alone */
        haptable_pair_load_of(tables->law, point.own.a, system.v[0], energy->load_n);
        if (terms == HAPTABLE_ENERGY_LOAD) return;
    }
    if (view->share < 1.0f) take_share(view->share, &link);
    tables->bend->slope(tables->model, contact, &point, system.v[0], terms == HAPTABLE_ENERGY_ALL, &slope);
    if (terms == HAPTABLE_ENERGY_ALL) {
        haptable_pair_vary(&link, system.v[0], system.v[1], &slope, &varied);
        put_gauss_newton(view, &system, &slope, &varied, energy->gauss_newton_j);
        for (int b = 0; b < 3; ++b) energy->hessian_j[b] = slope.second_j[b] + energy->gauss_newton_j[b];
        put_load_slope(tables->law, &point, &slope, energy->load_gradient_n);
    } else {
        const int count = pair_count(tables->law);
        float q[HAPTABLE_PAIR_CONTROLS], coupled_j[2];
        for (int b = 0; b < count; ++b) q[b] = mat_bilinear(link.row[b], system.v[0], system.v[1]);
        pair_coupled_slope(count, &link, q, coupled_j);
        for (int b = 0; b < 2; ++b) slope.first_j[b] -= coupled_j[b];
    }
    for (int b = 0; b < 2; ++b) energy->gradient_j[b] = slope.first_j[b];
}

void haptable_pair_energy(const struct haptable_model* model, const struct haptable_contact* contact,
                          const float finger_m[3], enum haptable_energy_terms terms, struct haptable_energy* energy) {
    const struct haptable_pair_view* view = pair_view_of(model);
    float felt_m[3];
    pair_felt(view, finger_m, felt_m);
    if (view->is_coupled)
        put_energy(view, contact, felt_m, terms, energy);
    else
        view->tables->model->energy(model, contact, felt_m, terms, energy);
}
