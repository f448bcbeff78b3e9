/* SPDX-License-Identifier: MIT
 *
 * (g_1, g_2) = argmin E over both places at once, E = 1/2 s . v,   [A_1 X; X^T A_2] v = s
 *
 * dE/dp = s_p . v - 1/2 v . A_p v,   d2E/dp dq = s_pq . v - 1/2 v . A_pq v + y_p . A^-1 y_q,   y_p = s_p - A_p v
 *
 * of the four area coordinates p that the two god-objects are free to move by; A and y are of both fingers. As one
 * finger's god-object does, the two follow their minimum to first order in both motions, and Newton's step, of both,
 * corrects that: so no order of the fingers is in what they feel. A step ends at the border of a patch; from there it
 * goes on into the patch across, along the edge or back, whatever leads down. Where E does not bend upwards, or that
 * takes too long, haptable_pair.c lets them move one after the other.
 */
#include "haptable_bounds.h"
#include "haptable_compliance.h"
#include "haptable_contact.h"
#include "haptable_pair_terms.h"
#include "haptable_patch.h"

/* The one finger's own sensitivity is not known, but the god-object stays where its finger does. */
static inline void pair_keep_known(struct haptable_servo* servo) {
    vec_zero(servo->sensitivity_per_m[0]);
    vec_zero(servo->sensitivity_per_m[1]);
    servo->sensitivity_per_m[0][0] = 1e-12f;
}

/* Over k, of blocks C_kl of so many controls each by k and then l; x is the first of the column. */
static inline void pair_sum_column(int count, const float w[], const float* x, float* restrict to) {
    if (count == HAPTABLE_PAIR_CONTROLS)
        pair_sum_six(w, x, (size_t)9 * HAPTABLE_PAIR_CONTROLS, to);
    else
        pair_sum_three(w, x, 27, to);
}

#define MOST_FREE 4

/* A finger's place. */
struct place {
    struct haptable_contact at;
    struct haptable_pair_point point;
    struct haptable_pair_slope slope;
    float weight[HAPTABLE_PAIR_CONTROLS];
    float slope_weight[2][HAPTABLE_PAIR_CONTROLS]; /* under a mask */
    float raw_j[2];                                /* v_1 . R_b v_2 */
    int free;        /* in how many ways it may move: 2 within a patch, 1 along an edge, 0 on a vertex */
    int corner;      /* of an edge: opposite to it; of a vertex: there */
    int is_held;     /* 1: it stays on its edge or vertex, as its patch was tried */
    float way[2][2]; /* each as a change of alpha_1, alpha_2 */
};

/* An evaluation. */
struct both {
    const struct haptable_pair_model* tables;
    const float* const* x_m;
    float felt_m[HAPTABLE_FINGERS][3]; /* where their dents end */
    int is_raised[HAPTABLE_FINGERS];   /* 1: not at x_m */
    float u[HAPTABLE_FINGERS][3];      /* to tell whether they press */
    struct place place[HAPTABLE_FINGERS];
    struct pair_system system;
    float row[HAPTABLE_PAIR_CONTROLS][9]; /* sum_l w_l C_kl */
    float x[9];
    struct meeting {
        int is_near;
        float share;    /* what is left of the coupling */
        float near;     /* 1 - r^2 / meeting_m^2 */
        float apart[3]; /* g_1 - g_2 */
        float whole_j;  /* v_1 . R v_2 */
    } meeting;
    float energy_j;
    int free; /* of both: the first finger's ways, then the second's */
    int is_given_up;
    int is_late;     /* 1: both were looked at already */
    int is_foreseen; /* 1: within the patches whose curvature an earlier tick took */
    int is_reused;   /* 1: that one told the step */
    float mixed_j[HAPTABLE_PAIR_CONTROLS][HAPTABLE_PAIR_CONTROLS]; /* v_1 . L_kl v_2 */
    float gradient_j[MOST_FREE];
    float y[MOST_FREE][HAPTABLE_FINGERS][3];
    /* What the next tick follows by, where the two rest: */
    float (*hessian_j)[MOST_FREE];
    float (*z)[HAPTABLE_FINGERS][3]; /* dv */
};

/* ---- where they are free to move ------------------------------------------------------------------------------- */

/* Along the edge from one corner to another. */
static void set_way(int from, int to, float way[2]) {
    way[0] = (float)(to == 1) - (float)(from == 1);
    way[1] = (float)(to == 2) - (float)(from == 2);
}

static void set_both_ways(struct place* here) {
    here->free = 2;
    here->way[0][0] = here->way[1][1] = 1.0f;
    here->way[0][1] = here->way[1][0] = 0.0f;
}

static void find_ways(struct place* here) {
    const enum place_on_patch feature = feature_of(here->at.alpha, &here->corner);
    set_both_ways(here);
    here->is_held = 0;
    if (feature == INSIDE) return;
    here->free = feature == ON_EDGE ? 1 : 0;
    if (feature == ON_EDGE) set_way(next_corner(here->corner), previous_corner(here->corner), here->way[0]);
}

/* dE by alpha_c towards corner c, the others giving way in proportion. */
static float slope_towards(const float alpha[3], const float gradient_j[2], int corner) {
    const float own = corner == 0 ? 0.0f : (corner == 1 ? gradient_j[0] : gradient_j[1]);
    return own - alpha[1] * gradient_j[0] - alpha[2] * gradient_j[1];
}

/* From an edge into its patch, or from a vertex along an edge, where E falls there. */
static void open_ways(struct place* here) {
    const float* alpha = here->at.alpha;
    const float* gradient_j = here->slope.first_j;
    if (here->free == 2 || here->is_held) return;
    if (here->free == 1) {
        if (slope_towards(alpha, gradient_j, here->corner) < 0.0f) set_both_ways(here);
    } else {
        const int one = next_corner(here->corner);
        const int two = previous_corner(here->corner);
        const float down_one = slope_towards(alpha, gradient_j, one);
        const float down_two = slope_towards(alpha, gradient_j, two);
        if (!(down_one < 0.0f || down_two < 0.0f)) return;
        here->free = 1;
        set_way(here->corner, down_one < down_two ? one : two, here->way[0]);
    }
}

/* How much of the step d is within the patch; the coordinate that ends there, or -1. */
static float part_within(const float alpha[3], const float d[2], int* ends) {
    const float change[3] = {-(d[0] + d[1]), d[0], d[1]};
    float part = 1.0f;
    int c;
    *ends = -1;
    if (alpha[0] + change[0] > 0.0f && alpha[1] + change[1] > 0.0f && alpha[2] + change[2] > 0.0f) return part;
    for (c = 0; c < 3; ++c) {
        if (!(change[c] < 0.0f && alpha[c] + part * change[c] <= 0.0f)) continue;
        part = alpha[c] / -change[c];
        *ends = c;
    }
    return part;
}

/* Moves by that part of d; `ends` becomes exactly 0, or none where it is -1. */
static void move_place(const struct haptable_model* model, const float d[2], float part, int ends,
                       struct haptable_contact* at) {
    const float change[3] = {-(d[0] + d[1]), d[0], d[1]};
    int c;
    if (ends < 0 && at->alpha[0] > 0.0f && at->alpha[1] > 0.0f && at->alpha[2] > 0.0f) { /* most steps */
        const float one = at->alpha[1] + part * d[0];
        const float two = at->alpha[2] + part * d[1];
        const float zero = 1.0f - one - two;
        if (zero > 0.0f) { /* beyond rounding */
            at->alpha[0] = zero;
            at->alpha[1] = one;
            at->alpha[2] = two;
            place(model, at);
            return;
        }
    }
    for (c = 0; c < 3; ++c)
        at->alpha[c] = c == ends || (at->alpha[c] == 0.0f && change[c] <= 0.0f)
                           ? 0.0f
                           : vec_clamp01(at->alpha[c] + part * change[c]);
    haptable_patch_complete(at->alpha);
    place(model, at);
}

/* ---- how two places are coupled --------------------------------------------------------------------------------- */

/* dw_k / d alpha_b of a mask's controls. */
static void put_slope_weights(const float alpha[3], float weight[2][HAPTABLE_PAIR_CONTROLS]) {
    weight[0][0] = weight[1][0] = -2.0f * alpha[0];
    weight[0][1] = 2.0f * alpha[1];
    weight[0][2] = 0.0f;
    weight[0][3] = 2.0f * alpha[2];
    weight[0][4] = -2.0f * alpha[2];
    weight[0][5] = 2.0f * (alpha[0] - alpha[1]);
    weight[1][1] = 0.0f;
    weight[1][2] = 2.0f * alpha[2];
    weight[1][3] = 2.0f * alpha[1];
    weight[1][4] = 2.0f * (alpha[0] - alpha[2]);
    weight[1][5] = -2.0f * alpha[1];
}

/* What the controls' x change by with alpha_b: without a mask only its own corner's and the first one's count. */
static inline void slope_of(const struct place* here, int b, const float (*x)[3], int count, float* restrict to) {
    const float* w = here->slope_weight[b];
    if (count < HAPTABLE_PAIR_CONTROLS) {
        vec_sub(x[b + 1], x[0], to);
        return;
    }
    to[0] = pair_six(w, &x[0][0], 3);
    to[1] = pair_six(w, &x[0][1], 3);
    to[2] = pair_six(w, &x[0][2], 3);
}

/* A finger's controls as the loads of both press on them, through the other's place. */
struct pressed {
    float by_other[HAPTABLE_PAIR_CONTROLS][3]; /* sum_l w_l L_kl v_2 */
    float back[HAPTABLE_PAIR_CONTROLS][3];     /* sum_l w_l L_kl^T v_1 */
};

/* v_1 . L v_2 by the products of their numbers. */
static inline float mixed_by(const float p[9], const float x[9]) {
    return p[0] * x[0] + p[1] * x[1] + p[2] * x[2] + p[3] * x[3] + p[4] * x[4] + p[5] * x[5] + p[6] * x[6] +
           p[7] * x[7] + p[8] * x[8];
}

static void put_mixed_of_controls(struct both* both, int count, const struct haptable_pair_net* net) {
    const float* one = both->system.v[0];
    const float* two = both->system.v[1];
    const float p[9] = {one[0] * two[0], one[0] * two[1], one[0] * two[2], one[1] * two[0], one[1] * two[1],
                        one[1] * two[2], one[2] * two[0], one[2] * two[1], one[2] * two[2]};
    const float* block = net->block[0];
    int k;
    int l;
    for (k = 0; k < count; ++k)
        for (l = 0; l < count; ++l, block += 9) both->mixed_j[k][l] = mixed_by(p, block);
}

/* Both fingers' controls. */
static void press(const struct both* both, int count, const struct haptable_pair_net* net,
                  struct pressed pressed[HAPTABLE_FINGERS]) {
    const float* one = both->system.v[0];
    const float* two = both->system.v[1];
    int k;
    int l;
    for (k = 0; k < count; ++k) {
        mat_product(both->row[k], two, pressed[0].by_other[k]);
        mat_transposed_product(both->row[k], one, pressed[0].back[k]);
    }
    for (l = 0; l < count; ++l) {
        float x[9];
        pair_sum_column(count, both->place[0].weight, net->block[l], x);
        mat_transposed_product(x, one, pressed[1].by_other[l]);
        mat_product(x, two, pressed[1].back[l]);
    }
}

/* ---- where they meet: X = share R, share = 1 - MEETING near^2 ------------------------------------------------- */

static void put_meeting(struct both* both) {
    const float per_m = 1.0f / both->tables->meeting_m;
    struct meeting* meeting = &both->meeting;
    vec_sub(both->place[0].at.god_object_m, both->place[1].at.god_object_m, meeting->apart);
    meeting->near = 1.0f - vec_dot(meeting->apart, meeting->apart) * per_m * per_m;
    meeting->is_near = meeting->near > 0.0f;
    meeting->share = meeting->is_near ? 1.0f - HAPTABLE_PAIR_MEETING * meeting->near * meeting->near : 1.0f;
}

/* near by a coordinate of finger f whose edge is e */
static float near_slope(const struct both* both, int f, const float e[3]) {
    const float per_m = 1.0f / both->tables->meeting_m;
    const float along = vec_dot(both->meeting.apart, e);
    return (f == 0 ? -2.0f : 2.0f) * per_m * per_m * along;
}

/* share by the same */
static float meeting_slope(const struct both* both, int f, const float e[3]) {
    return -2.0f * HAPTABLE_PAIR_MEETING * both->meeting.near * near_slope(both, f, e);
}

/* The second derivative of v_1 . X v_2, by coordinates of fingers f and g, of which raw is R's, and first and second
 * are R's first ones. */
static float meeting_bend(const struct both* both, int f, const float e[3], int g, const float d[3], float first,
                          float second, float raw) {
    const struct meeting* meeting = &both->meeting;
    const float per_m = 1.0f / both->tables->meeting_m;
    const float near_second = (f == g ? -2.0f : 2.0f) * per_m * per_m * vec_dot(e, d);
    const float share_second =
        -2.0f * HAPTABLE_PAIR_MEETING * (near_slope(both, f, e) * near_slope(both, g, d) + meeting->near * near_second);
    return share_second * meeting->whole_j + meeting_slope(both, f, e) * second + meeting_slope(both, g, d) * first +
           meeting->share * raw;
}

/* v_1 . X_bb' v_2 of the one finger's own coordinates, under a mask, whose weights are quadratic: 11 12 22. */
static void put_second(const float q[HAPTABLE_PAIR_CONTROLS], float second_j[3]) {
    second_j[0] = 2.0f * (q[1] - 2.0f * q[pair_control_of(1, 0)] + q[0]);
    second_j[1] = 2.0f * (q[pair_control_of(1, 2)] - q[pair_control_of(1, 0)] - q[pair_control_of(2, 0)] + q[0]);
    second_j[2] = 2.0f * (q[2] - 2.0f * q[pair_control_of(2, 0)] + q[0]);
}

/* Where they meet: what the share's own slope adds. x_v: X_b v of the other; back: X_b^T v of this one. */
static void couple_meeting(const struct both* both, int f, float x_v[2][3], float back[2][3]) {
    const float* v = both->system.v[f];
    const struct place* here = &both->place[f];
    float there[3]; /* R v */
    float back_v[3];
    int b;
    if (f == 0) {
        mat_product(both->x, both->system.v[1], there);
        mat_transposed_product(both->x, v, back_v);
    } else {
        mat_transposed_product(both->x, both->system.v[0], there);
        mat_product(both->x, v, back_v);
    }
    for (b = 0; b < 2; ++b) {
        const float slope = meeting_slope(both, f, here->point.e[b]) / both->meeting.share;
        float scaled[3] = {0.0f, 0.0f, 0.0f};
        vec_add_scaled(both->meeting.share, x_v[b], scaled);
        vec_add_scaled(slope, there, scaled);
        vec_copy(scaled, x_v[b]);
        vec_zero(scaled);
        vec_add_scaled(both->meeting.share, back[b], scaled);
        vec_add_scaled(slope, back_v, scaled);
        vec_copy(scaled, back[b]);
    }
}

/* Takes what the coupling has off one finger's slope. back: what its coordinates do to the other's equations. */
static void couple(struct both* both, int count, const struct pressed* pressed, int f, float back[2][3]) {
    const float* v = both->system.v[f];
    struct place* here = &both->place[f];
    struct haptable_pair_slope* slope = &here->slope;
    float second_j[3] = {0.0f, 0.0f, 0.0f};
    float x_v[2][3];
    int b;
    for (b = 0; b < 2; ++b) {
        slope_of(here, b, (const float(*)[3])pressed->by_other, count, x_v[b]);
        slope_of(here, b, (const float(*)[3])pressed->back, count, back[b]);
        here->raw_j[b] = vec_dot(v, x_v[b]);
    }
    if (count == HAPTABLE_PAIR_CONTROLS) {
        float q[HAPTABLE_PAIR_CONTROLS];
        int k;
        for (k = 0; k < HAPTABLE_PAIR_CONTROLS; ++k) q[k] = vec_dot(v, pressed->by_other[k]);
        put_second(q, second_j);
    }
    if (both->meeting.is_near) {
        const float* e[2] = {here->point.e[0], here->point.e[1]};
        const float* raw = here->raw_j;
        second_j[0] = meeting_bend(both, f, e[0], f, e[0], raw[0], raw[0], second_j[0]);
        second_j[1] = meeting_bend(both, f, e[0], f, e[1], raw[0], raw[1], second_j[1]);
        second_j[2] = meeting_bend(both, f, e[1], f, e[1], raw[1], raw[1], second_j[2]);
        couple_meeting(both, f, x_v, back);
    }
    vec_sub(slope->second_j, second_j, slope->second_j);
    for (b = 0; b < 2; ++b) {
        vec_sub(slope->y[b], x_v[b], slope->y[b]);
        slope->first_j[b] -= vec_dot(v, x_v[b]);
    }
}

/* v_1 . R_bc v_2 by coordinates b of the first and c of the second. */
static void put_raw_mixed(const struct both* both, int count, float mixed[2][2]) {
    const float(*mixed_j)[HAPTABLE_PAIR_CONTROLS] = (const float(*)[HAPTABLE_PAIR_CONTROLS])both->mixed_j;
    const struct place* here = both->place;
    int b;
    int c;
    int k;
    if (count < HAPTABLE_PAIR_CONTROLS) {
        for (b = 0; b < 2; ++b)
            for (c = 0; c < 2; ++c)
                mixed[b][c] = mixed_j[b + 1][c + 1] - mixed_j[b + 1][0] - mixed_j[0][c + 1] + mixed_j[0][0];
        return;
    }
    for (c = 0; c < 2; ++c) {
        float row[HAPTABLE_PAIR_CONTROLS];
        for (k = 0; k < HAPTABLE_PAIR_CONTROLS; ++k) row[k] = pair_six(here[1].slope_weight[c], mixed_j[k], 1);
        for (b = 0; b < 2; ++b) mixed[b][c] = pair_six(here[0].slope_weight[b], row, 1);
    }
}

/* ---- an evaluation ------------------------------------------------------------------------------------------------
 */

/* X of both places, and what the controls of the first have of it. */
static void put_rows(struct both* both, const struct haptable_pair_net* net) {
    const int count = pair_count(both->tables->law);
    const float* block = net->block[0];
    int k;
    for (k = 0; k < count; ++k, block += 9 * (size_t)count)
        pair_sum(count, both->place[1].weight, block, 9, both->row[k]);
    pair_sum(count, both->place[0].weight, both->row[0], 9, both->x);
    if (both->meeting.is_near) mat_scale(both->meeting.share, both->x, both->x);
}

/* v of both, and the energy, of places whose points are known. Returns 0 where N is lifted. */
static int solve_points(struct both* both, struct haptable_pair_net* net) {
    const struct haptable_pair_model* tables = both->tables;
    struct place* here = both->place;
    const struct haptable_pair_own* own[HAPTABLE_FINGERS] = {&here[0].point.own, &here[1].point.own};
    float(*u)[3] = both->u;
    float dent[HAPTABLE_FINGERS][3];
    int f;
    put_meeting(both);
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        pair_weights(pair_count(tables->law), here[f].at.alpha, here[f].weight);
        vec_sub(both->x_m[f], here[f].at.god_object_m, u[f]);
        vec_copy(here[f].point.u, dent[f]);
        if (both->is_raised[f]) haptable_pair_inwards(tables->model, here[f].at.patch, u[f]);
    }
    put_rows(both, haptable_pair_net_of(tables, net, here[0].at.patch, here[1].at.patch));
    haptable_pair_press_alone(tables->law, own[0], own[1], u, dent, both->x, &both->system);
    haptable_pair_press_both(own[0], own[1], both->x, &both->system);
    both->energy_j = 0.5f * (vec_dot(own[0]->s, both->system.v[0]) + vec_dot(own[1]->s, both->system.v[1]));
    return !both->system.lifted;
}

/* The same with what slopes are made of. */
static int solve_places(struct both* both, struct haptable_pair_net* net) {
    const struct haptable_pair_model* tables = both->tables;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        tables->bend->open(tables->model, &here->at, both->felt_m[f], &here->point);
    }
    return solve_points(both, net);
}

/* The same without it, of places that have moved within their patches. */
static int solve_again(struct both* both, struct haptable_pair_net* net) {
    const struct haptable_pair_model* tables = both->tables;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        tables->law->own(tables->model, &here->at, both->felt_m[f], &here->point.own);
        vec_sub(both->felt_m[f], here->at.god_object_m, here->point.u);
    }
    return solve_points(both, net);
}

static void set_scaled(float s, const float a[3], float out[3]) {
    out[0] = s * a[0];
    out[1] = s * a[1];
    out[2] = s * a[2];
}

/* Of a finger on an edge. */
static void put_edge_way(struct both* both, int f, int begin, float back[2][3]) {
    const struct place* here = &both->place[f];
    const float* second_j = here->slope.second_j;
    const float* way = here->way[0];
    float(*y)[3] = both->y[begin];
    both->gradient_j[begin] = way[0] * here->slope.first_j[0] + way[1] * here->slope.first_j[1];
    set_scaled(way[0], here->slope.y[0], y[f]);
    vec_add_scaled(way[1], here->slope.y[1], y[f]);
    set_scaled(-way[0], back[0], y[1 - f]);
    vec_add_scaled(-way[1], back[1], y[1 - f]);
    both->hessian_j[begin][begin] =
        way[0] * way[0] * second_j[0] + 2.0f * way[0] * way[1] * second_j[1] + way[1] * way[1] * second_j[2];
}

/* Gradient, y and curvature by the ways of a finger. */
static void put_ways(struct both* both, int f, float back[2][3]) {
    const struct place* here = &both->place[f];
    const float* second_j = here->slope.second_j;
    const int begin = f == 0 ? 0 : both->place[0].free;
    int i;
    if (here->free == 1) put_edge_way(both, f, begin, back);
    if (here->free < 2) return;
    for (i = 0; i < 2; ++i) {
        vec_copy(here->slope.y[i], both->y[begin + i][f]);
        set_scaled(-1.0f, back[i], both->y[begin + i][1 - f]);
        both->gradient_j[begin + i] = here->slope.first_j[i];
    }
    both->hessian_j[begin][begin] = second_j[0];
    both->hessian_j[begin + 1][begin] = second_j[1];
    both->hessian_j[begin + 1][begin + 1] = second_j[2];
}

/* The curvature between the ways of the two: -v_1 . X_bc v_2. */
static void put_mixed(struct both* both, int count) {
    const struct place* here = both->place;
    float mixed[2][2];
    int b;
    int c;
    put_raw_mixed(both, count, mixed);
    if (both->meeting.is_near)
        for (b = 0; b < 2; ++b)
            for (c = 0; c < 2; ++c)
                mixed[b][c] = meeting_bend(both, 0, here[0].point.e[b], 1, here[1].point.e[c], here[0].raw_j[b],
                                           here[1].raw_j[c], mixed[b][c]);
    if (here[0].free == 2 && here[1].free == 2) { /* most */
        both->hessian_j[2][0] = -mixed[0][0];
        both->hessian_j[2][1] = -mixed[1][0];
        both->hessian_j[3][0] = -mixed[0][1];
        both->hessian_j[3][1] = -mixed[1][1];
        return;
    }
    for (b = 0; b < here[0].free; ++b)
        for (c = 0; c < here[1].free; ++c) {
            const float* one = here[0].way[b];
            const float* two = here[1].way[c];
            both->hessian_j[here[0].free + c][b] = -(one[0] * (two[0] * mixed[0][0] + two[1] * mixed[0][1]) +
                                                     one[1] * (two[0] * mixed[1][0] + two[1] * mixed[1][1]));
        }
}

/* dv = A^-1 y */
static void solve_slope(const struct pair_system* system, float y[HAPTABLE_FINGERS][3], float z[HAPTABLE_FINGERS][3]) {
    float t[3];
    mat_product(system->xm, y[1], t);
    vec_sub(y[0], t, t);
    sym_solve(&system->n, t, z[0]);
    vec_symmetric_product(system->m, y[1], z[1]);
    mat_transposed_product(system->xm, z[0], t);
    vec_sub(z[1], t, z[1]);
}

static void put_slopes(struct both* both, int count, const struct haptable_pair_net* net) {
    struct pressed pressed[HAPTABLE_FINGERS];
    int i;
    int j;
    press(both, count, net, pressed);
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        struct place* here = &both->place[i];
        float back[2][3];
        couple(both, count, &pressed[i], i, back);
        open_ways(here);
        put_ways(both, i, back);
    }
    both->free = both->place[0].free + both->place[1].free;
    put_mixed(both, count);
    for (i = 0; i < both->free; ++i) {
        solve_slope(&both->system, both->y[i], both->z[i]);
        for (j = 0; j <= i; ++j)
            both->hessian_j[i][j] += vec_dot(both->y[i][0], both->z[j][0]) + vec_dot(both->y[i][1], both->z[j][1]);
    }
}

/* What both have of their slopes alone, of the places where they are, and what couples these. Returns 0 where they
 * cannot settle together. */
static int evaluate(struct both* both, int count, struct haptable_pair* pair) {
    const struct haptable_pair_model* tables = both->tables;
    int f;
    ++pair->evaluations;
    if (!solve_places(both, &pair->net)) return 0;
    if (both->meeting.is_near)
        both->meeting.whole_j = mat_bilinear(both->x, both->system.v[0], both->system.v[1]) / both->meeting.share;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        if (count == HAPTABLE_PAIR_CONTROLS) put_slope_weights(here->at.alpha, here->slope_weight);
        tables->bend->slope(tables->model, &here->at, &here->point, both->system.v[f], &here->slope);
    }
    put_mixed_of_controls(both, count, &pair->net);
    return 1;
}

/* ---- Newton's step ------------------------------------------------------------------------------------------------
 */

/* The inverse of a pivot; 0 where it is not positive beyond rounding. */
static float pivot(float left, float whole) { return left > 1e-5f * whole && whole > 0.0f ? 1.0f / left : 0.0f; }

/* H = L D L^T in place: D's inverse on the diagonal, 0 beyond the ways. Returns 0 where H is not positive definite
 * beyond rounding. Every number is a statement of its own, as loops would cost more than what they do. */
static int factor_curvature(float h[MOST_FREE][MOST_FREE], int free) {
    float l0;
    float l1;
    float l2;
    int i;
    for (i = free; i < MOST_FREE; ++i) vec_zero(h[i]);
    for (i = free; i < MOST_FREE; ++i) h[i][i] = 0.0f;
    if (free < 1) return 1;
    h[0][0] = pivot(h[0][0], h[0][0]);
    if (h[0][0] == 0.0f) return 0;
    if (free < 2) return 1;
    l0 = h[1][0] * h[0][0];
    h[1][1] = pivot(h[1][1] - l0 * h[1][0], h[1][1]);
    h[1][0] = l0;
    if (h[1][1] == 0.0f) return 0;
    if (free < 3) return 1;
    h[2][1] -= h[2][0] * h[1][0];
    l0 = h[2][0] * h[0][0];
    l1 = h[2][1] * h[1][1];
    h[2][2] = pivot(h[2][2] - l0 * h[2][0] - l1 * h[2][1], h[2][2]);
    h[2][0] = l0;
    h[2][1] = l1;
    if (h[2][2] == 0.0f) return 0;
    if (free < 4) return 1;
    h[3][1] -= h[3][0] * h[1][0];
    h[3][2] -= h[3][0] * h[2][0] + h[3][1] * h[2][1];
    l0 = h[3][0] * h[0][0];
    l1 = h[3][1] * h[1][1];
    l2 = h[3][2] * h[2][2];
    h[3][3] = pivot(h[3][3] - l0 * h[3][0] - l1 * h[3][1] - l2 * h[3][2], h[3][3]);
    h[3][0] = l0;
    h[3][1] = l1;
    h[3][2] = l2;
    return h[3][3] != 0.0f;
}

/* H^-1 b in place, b being 0 beyond the ways. */
static inline void solve_curvature(float h[MOST_FREE][MOST_FREE], float* restrict b) {
    const float b0 = b[0];
    const float b1 = b[1] - h[1][0] * b0;
    const float b2 = b[2] - (h[2][0] * b0 + h[2][1] * b1);
    const float b3 = b[3] - (h[3][0] * b0 + h[3][1] * b1 + h[3][2] * b2);
    b[3] = b3 * h[3][3];
    b[2] = b2 * h[2][2] - h[3][2] * b[3];
    b[1] = b1 * h[1][1] - h[2][1] * b[2] - h[3][1] * b[3];
    b[0] = b0 * h[0][0] - h[1][0] * b[1] - h[2][0] * b[2] - h[3][0] * b[3];
}

/* How the alphas of a finger change by a step of both. */
static void step_of(const struct both* both, int f, const float step[MOST_FREE], float d[2]) {
    const struct place* here = &both->place[f];
    const float* own = f == 0 ? step : &step[both->place[0].free];
    d[0] = here->free > 0 ? own[0] * here->way[0][0] : 0.0f;
    d[1] = here->free > 0 ? own[0] * here->way[0][1] : 0.0f;
    if (here->free == 2) d[1] += own[1];
}

/* The same place as another patch sees it, and the gradient there, the other finger being as it was told: v is the
 * same. */
static void see_from(const struct both* both, struct haptable_pair* pair, int f, uint16_t patch, float alpha[3],
                     float gradient_j[2]) {
    const struct haptable_pair_model* tables = both->tables;
    const struct place* here = &both->place[f];
    const uint16_t* vertex = tables->model->patch[here->at.patch];
    const float(*x)[9] = (const float(*)[9])haptable_pair_gather(&pair->view[f], patch)->x;
    const float* v = both->system.v[f];
    struct haptable_pair_point point;
    struct haptable_pair_slope slope;
    struct haptable_contact at = here->at;
    const int count = pair_count(tables->law);
    float q[HAPTABLE_PAIR_CONTROLS]; /* v . x_k v_other */
    float coupled[2];
    int b;
    int k;
    ++pair->looks;
    at.patch = patch;
    vec_zero(at.alpha);
    for (k = 0; k < 3; ++k)
        if (here->at.alpha[k] > 0.0f) at.alpha[corner_of(tables->model, patch, vertex[k])] = here->at.alpha[k];
    tables->bend->open(tables->model, &at, both->felt_m[f], &point);
    tables->bend->slope(tables->model, &at, &point, v, &slope);
    for (k = 0; k < count; ++k) q[k] = mat_bilinear(x[k], v, both->system.v[1 - f]);
    if (count == HAPTABLE_PAIR_CONTROLS) {
        float weight[2][HAPTABLE_PAIR_CONTROLS];
        put_slope_weights(at.alpha, weight);
        coupled[0] = pair_six(weight[0], q, 1);
        coupled[1] = pair_six(weight[1], q, 1);
    } else {
        /* cppcheck-suppress uninitvar ; the count is 3 or 6 */
        coupled[0] = q[1] - q[0];
        coupled[1] = q[2] - q[0];
    }
    for (b = 0; b < 2; ++b) gradient_j[b] = slope.first_j[b] - both->meeting.share * coupled[b];
    if (both->meeting.is_near) {
        float whole = 0.0f;
        float shared[HAPTABLE_PAIR_CONTROLS];
        pair_weights(count, at.alpha, shared);
        for (k = 0; k < count; ++k) whole += shared[k] * q[k];
        for (b = 0; b < 2; ++b) gradient_j[b] -= whole * meeting_slope(both, f, point.e[b]);
    }
    vec_copy(at.alpha, alpha);
}

/* 0, and given up, where the tick has no look left. */
static int may_look(struct both* both, const struct haptable_pair* pair) {
    if (pair->looks >= HAPTABLE_PAIR_LOOKS) both->is_given_up = 1;
    return !both->is_given_up;
}

/* Always 1. */
static int go_to(struct place* here, uint16_t patch, const float alpha[3]) {
    here->at.patch = patch;
    vec_copy(alpha, here->at.alpha);
    return 1;
}

/* 1 where E falls into another patch of the edge: then it is on that one. */
static int falls_across(struct both* both, struct haptable_pair* pair, int f) {
    struct place* here = &both->place[f];
    struct across across = across_begin(both->tables->model, here->at.patch, here->corner);
    for (; across.patch != HAPTABLE_NONE && may_look(both, pair); across_next(both->tables->model, &across)) {
        float alpha[3];
        float gradient_j[2];
        int opposite = 0;
        see_from(both, pair, f, across.patch, alpha, gradient_j);
        (void)feature_of(alpha, &opposite);
        if (slope_towards(alpha, gradient_j, opposite) < 0.0f) return go_to(here, across.patch, alpha);
    }
    return 0;
}

/* 1 where one of the patch's edges at the corner leads down. */
static int falls_from(const float alpha[3], const float gradient_j[2], int corner) {
    return slope_towards(alpha, gradient_j, next_corner(corner)) < 0.0f ||
           slope_towards(alpha, gradient_j, previous_corner(corner)) < 0.0f;
}

/* 1 where E falls along an edge of the vertex, as its slope is linear on each patch's cone there: then it is on a patch
 * with that edge. */
static int falls_around(struct both* both, struct haptable_pair* pair, int f) {
    struct place* here = &both->place[f];
    struct fan fan = fan_begin(both->tables->model, here->at.patch, here->corner);
    while (fan_next(both->tables->model, &fan) && may_look(both, pair)) {
        float alpha[3];
        float gradient_j[2];
        see_from(both, pair, f, fan.patch, alpha, gradient_j);
        if (falls_from(alpha, gradient_j, fan.corner)) return go_to(here, fan.patch, alpha);
    }
    return 0;
}

/* 1 where a finger is within its patch, or E falls off its edge or vertex nowhere; else it is on another patch. */
static int rests_across(struct both* both, struct haptable_pair* pair, int f) {
    const struct place* here = &both->place[f];
    int corner;
    if (here->free == 2) return 1;
    haptable_pair_look(both->tables, &both->place[1 - f].at, &pair->view[f]);
    return feature_of(here->at.alpha, &corner) == ON_EDGE ? !falls_across(both, pair, f) : !falls_around(both, pair, f);
}

/* Newton's step may be this much of a patch where it ends a tick: its own error is of the order of its square. One
 * finger's is held to less (HAPTABLE_CORRECTION): of two an evaluation is dear, and loops give no more with this. */
#define CORRECTION 1e-2f

/* 1 where a step is so small that it ends the tick. */
static int is_small(const float d[2]) {
    return d[0] < CORRECTION && d[0] > -CORRECTION && d[1] < CORRECTION && d[1] > -CORRECTION &&
           d[0] + d[1] < CORRECTION && d[0] + d[1] > -CORRECTION;
}

/* ---- what the tick ends with --------------------------------------------------------------------------------------
 */

/* See haptable_least_energy.c: v is taken to first order where neither it nor u changes by more than this. */
#define LOAD_CORRECTION 2.5e-3f

/* The same by slopes of an earlier tick, which may be a quarter off: so that leaves as little, LOAD_CORRECTION squared.
 */
#define REUSED_LOAD_CORRECTION 2.5e-5f

/* v of a finger after a step, to first order. Returns 0 where that does not do. */
static int step_load(const struct both* both, int f, const float step[MOST_FREE], float moved2, float v[3]) {
    const float part = both->is_reused ? REUSED_LOAD_CORRECTION : LOAD_CORRECTION;
    const float most = part * part;
    float change[3] = {0.0f, 0.0f, 0.0f};
    int i;
    vec_copy(both->system.v[f], v);
    for (i = 0; i < both->free; ++i) vec_add_scaled(step[i], both->z[i][f], change);
    vec_add_scaled(1.0f, change, v);
    return !both->place[f].point.steps && moved2 <= most * vec_dot(both->place[f].point.u, both->place[f].point.u) &&
           vec_dot(change, change) <= most * vec_dot(v, v);
}

/* What the loads' slopes are made of, beside those of v, where these are not the loads. */
static void put_follow(const struct both* both, struct haptable_pair_follow* follow) {
    int i = 0;
    int f;
    follow->free = (uint8_t)both->free;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        const struct place* here = &both->place[f];
        int way;
        follow->patch[f] = here->at.patch;
        if (!both->tables->law->is_stiffness) continue;
        vec_copy(&here->point.own.a[0], &follow->a[f][0]);
        vec_copy(&here->point.own.a[3], &follow->a[f][3]);
        for (way = 0; way < here->free; ++way, ++i) {
            set_scaled(here->way[way][0], here->slope.a_v[0], follow->a_v[i]);
            vec_add_scaled(here->way[way][1], here->slope.a_v[1], follow->a_v[i]);
        }
    }
}

static void put_loads(struct both* both, float v[HAPTABLE_FINGERS][3]) {
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        if (both->tables->law->is_stiffness)
            vec_symmetric_product(here->point.own.a, v[f], here->at.load_n);
        else
            vec_copy(v[f], here->at.load_n);
    }
}

/* 1 where no finger could be seen from its god-object, so that nobody need look again. */
static int are_surely_inside(const struct both* both) {
    const struct place* here = both->place;
    return haptable_contact_surely_presses(both->tables->model, &here[0].at, both->x_m[0]) &&
           haptable_contact_surely_presses(both->tables->model, &here[1].at, both->x_m[1]);
}

/* The places and v are the tick's. */
static void rest(const struct both* both, struct haptable_pair* pair, float v[HAPTABLE_FINGERS][3], float energy_j) {
    int f;
    if (!both->is_reused) put_follow(both, &pair->follow);
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct haptable_servo* servo = &pair->servo[f];
        servo->contact = both->place[f].at;
        pair_keep_known(servo);
        vec_copy(both->x_m[f], servo->finger_m); /* it stays, and so does a god-object that rests */
        vec_copy(v[f], pair->view[f].v);
        pair->view[f].is_solved = 1;
    }
    pair->energy_j = energy_j;
    pair->is_following = both->is_reused ? (uint8_t)(pair->is_following + 1) : 1;
}

/* Where a step of one is foreseen to lead: along its ways, or off its edge into the patch. */
static void predict_place(const struct haptable_model* model, const float d[2], struct place* here) {
    int ends;
    const float part = part_within(here->at.alpha, d, &ends);
    if (ends >= 0) {
        const uint16_t across = model->neighbour[here->at.patch][ends];
        float aim[3];
        float edge[2][3];
        float normal[3];
        patch_frame(model, here->at.patch, edge[0], edge[1], normal);
        vec_copy(here->at.god_object_m, aim);
        vec_add_scaled(d[0], edge[0], aim);
        vec_add_scaled(d[1], edge[1], aim);
        if (here->free == 2 && across != HAPTABLE_NONE)
            haptable_patch_nearest(model, across, aim, &here->at);
        else
            move_place(model, d, part, ends, &here->at);
        find_ways(here);
    } else {
        move_place(model, d, 1.0f, -1, &here->at);
        if (here->free < 2) find_ways(here);
    }
}

/* Both where a step of both leads, at most to a border. Returns how much of it that is. */
static float step_places(const struct both* both, float d[HAPTABLE_FINGERS][2],
                         struct haptable_contact to[HAPTABLE_FINGERS]) {
    float part[HAPTABLE_FINGERS];
    float least;
    int ends[HAPTABLE_FINGERS];
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) part[f] = part_within(both->place[f].at.alpha, d[f], &ends[f]);
    least = part[0] < part[1] ? part[0] : part[1];
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        to[f] = both->place[f].at;
        move_place(both->tables->model, d[f], least, part[f] == least ? ends[f] : -1, &to[f]);
    }
    return least;
}

/* What evaluates next begins there. A step that leads off an edge or a vertex at once leaves them on it. */
static void go_places(struct both* both, float part, float d[HAPTABLE_FINGERS][2],
                      const struct haptable_contact to[HAPTABLE_FINGERS]) {
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        int ends;
        const int held = part == 0.0f && part_within(here->at.alpha, d[f], &ends) == 0.0f;
        here->at = to[f];
        find_ways(here);
        here->is_held = held;
    }
}

/* The tick's end, where the step is small. Returns 1 where the two rest, 0 where one goes on over an edge, -1 where
 * they cannot settle together. */
static int end(struct both* both, struct haptable_pair* pair, const float step[MOST_FREE], float fall_j,
               const struct haptable_contact to[HAPTABLE_FINGERS]) {
    float v[HAPTABLE_FINGERS][3];
    int known = 1;
    int rests = 1;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) rests = rests_across(both, pair, f) && rests;
    if (both->is_given_up) return -1;
    if (!rests) {
        find_ways(&both->place[0]);
        find_ways(&both->place[1]);
        return 0;
    }
    for (f = 0; f < HAPTABLE_FINGERS; ++f)
        known = step_load(both, f, step, gap2(to[f].god_object_m, both->place[f].at.god_object_m), v[f]) && known;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) both->place[f].at = to[f];
    if (!known) {
        if (!solve_again(both, &pair->net)) return -1;
        for (f = 0; f < HAPTABLE_FINGERS; ++f) vec_copy(both->system.v[f], v[f]);
    }
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        const struct haptable_pair_point* point = &both->place[f].point;
        float normal[3];
        vec_cross(point->e[0], point->e[1], normal);
        haptable_pair_keep_pressing(both->tables, normal, &point->own, both->is_raised[f], both->u[f], f,
                                    &both->system);
    }
    if (both->system.touches[0] != both->system.touches[1]) {
        pair->touches[both->system.touches[0] ? 1 : 0] = 0;
        return -1;
    }
    put_loads(both, v);
    if (both->is_late && !are_surely_inside(both)) return -1;
    rest(both, pair, v, both->energy_j + (known ? fall_j : 0.0f));
    return 1;
}

/* Newton's step after an evaluation. Returns 1 where the two rest after it, -1 where they cannot settle together, and 0
 * where another evaluation is to be made. */
static int go_on(struct both* both, struct haptable_pair* pair, float most_j) {
    struct haptable_contact to[HAPTABLE_FINGERS];
    float d[HAPTABLE_FINGERS][2];
    float step[MOST_FREE];
    float fall_j = 0.0f;
    float part;
    int i;
    if (!(both->energy_j <= most_j)) return -1;
    if (!factor_curvature(both->hessian_j, both->free)) return -1;
    for (i = 0; i < MOST_FREE; ++i) step[i] = i < both->free ? -both->gradient_j[i] : 0.0f;
    solve_curvature(both->hessian_j, step);
    for (i = 0; i < both->free; ++i) fall_j += 0.5f * step[i] * both->gradient_j[i];
    step_of(both, 0, step, d[0]);
    step_of(both, 1, step, d[1]);
    part = step_places(both, d, to);
    if (part == 1.0f && is_small(d[0]) && is_small(d[1])) return end(both, pair, step, fall_j, to);
    go_places(both, part, d, to);
    return 0;
}

/* As much of E's slope as the coupling has, by coordinate b of a finger whose controls have q. */
static inline float coupled_slope(const struct place* here, int b, int count, const float q[HAPTABLE_PAIR_CONTROLS]) {
    return count == HAPTABLE_PAIR_CONTROLS ? pair_six(here->slope_weight[b], q, 1) : q[b + 1] - q[0];
}

/* The gradient of both within their patches, apart from each other, with its sign turned. */
static void put_descent(const struct both* both, float step[MOST_FREE]) {
    const struct place* here = both->place;
    const int count = pair_count(both->tables->law);
    float q[HAPTABLE_FINGERS][HAPTABLE_PAIR_CONTROLS];
    int k;
    int b;
    for (k = 0; k < count; ++k) {
        const float* row = both->mixed_j[k];
        const float* column = &both->mixed_j[0][k];
        if (count == HAPTABLE_PAIR_CONTROLS) {
            q[0][k] = pair_six(here[1].weight, row, 1);
            q[1][k] = pair_six(here[0].weight, column, HAPTABLE_PAIR_CONTROLS);
        } else {
            q[0][k] = pair_three(here[1].weight, row, 1);
            q[1][k] = pair_three(here[0].weight, column, HAPTABLE_PAIR_CONTROLS);
        }
    }
    for (b = 0; b < 2; ++b) {
        step[b] = coupled_slope(&here[0], b, count, q[0]) - here[0].slope.first_j[b];
        step[2 + b] = coupled_slope(&here[1], b, count, q[1]) - here[1].slope.first_j[b];
    }
}

/* A step by the curvature of an earlier tick ends a tick where it is this small: what it leaves is a part of it. */
#define REUSED_CORRECTION 2e-3f

static int is_tiny(const float d[2]) {
    return d[0] < REUSED_CORRECTION && d[0] > -REUSED_CORRECTION && d[1] < REUSED_CORRECTION &&
           d[1] > -REUSED_CORRECTION;
}

/* The same as go_on by the curvature that the two were foreseen by, where the step is so small that this does. */
static int reuse(struct both* both, struct haptable_pair* pair) {
    struct haptable_contact to[HAPTABLE_FINGERS];
    float d[HAPTABLE_FINGERS][2];
    float descent_j[MOST_FREE];
    float step[MOST_FREE];
    float fall_j = 0.0f;
    int i;
    put_descent(both, descent_j);
    for (i = 0; i < MOST_FREE; ++i) step[i] = descent_j[i];
    solve_curvature(both->hessian_j, step);
    step_of(both, 0, step, d[0]);
    step_of(both, 1, step, d[1]);
    if (!(is_tiny(d[0]) && is_tiny(d[1])) || step_places(both, d, to) < 1.0f) return 0;
    for (i = 0; i < MOST_FREE; ++i) fall_j -= 0.5f * step[i] * descent_j[i];
    both->is_reused = 1;
    return end(both, pair, step, fall_j, to);
}

/* How much less steep the motions make E, by the ways: as the loads go with these. */
static void slope_of_follow(const struct both* both, const struct haptable_pair_follow* follow,
                            float motion_m[HAPTABLE_FINGERS][3], float step[MOST_FREE]) {
    float by[HAPTABLE_FINGERS][3];
    int i;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        if (both->tables->law->is_stiffness)
            vec_symmetric_product(follow->a[f], motion_m[f], by[f]);
        else
            vec_copy(motion_m[f], by[f]);
    }
    for (i = 0; i < both->free; ++i) {
        step[i] = -vec_dot(follow->slope[i][0], by[0]) - vec_dot(follow->slope[i][1], by[1]);
        if (both->tables->law->is_stiffness)
            step[i] -= vec_dot(follow->a_v[i], motion_m[i < both->place[0].free ? 0 : 1]);
    }
}

/* Where the fingers' motions take the minimum: -H^-1 (slopes . motions). Over an edge it goes on to the point of the
 * patch there that is nearest to where that leads. */
static void predict(struct both* both, struct haptable_pair* pair) {
    struct haptable_pair_follow* follow = &pair->follow;
    float motion_m[HAPTABLE_FINGERS][3];
    float step[MOST_FREE];
    int f;
    int i;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        if (follow->patch[f] != both->place[f].at.patch) return;
        vec_sub(both->x_m[f], pair->servo[f].finger_m, motion_m[f]);
    }
    if (follow->free != both->free) return;
    for (i = 0; i < MOST_FREE; ++i) step[i] = 0.0f;
    slope_of_follow(both, follow, motion_m, step);
    solve_curvature(follow->curvature_j, step);
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        float d[2];
        step_of(both, f, step, d);
        predict_place(both->tables->model, d, &both->place[f]);
    }
    both->free = both->place[0].free + both->place[1].free;
    both->is_foreseen = both->free == MOST_FREE && both->place[0].at.patch == follow->patch[0] &&
                        both->place[1].at.patch == follow->patch[1] && pair->is_following < HAPTABLE_PAIR_REUSED;
}

static int may_settle(const struct haptable_pair* pair, int f) {
    const struct haptable_servo* servo = &pair->servo[f];
    return servo->contact.patch != HAPTABLE_NONE && servo->finger_known && pair->touches[f] &&
           !servo->segment.unfinished && servo->undecided_ticks == 0 && (servo->buttons & HAPTABLE_BUTTON_GRAB) == 0;
}

static int begin_both(struct both* both, struct haptable_pair* pair) {
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        if (!may_settle(pair, f)) return 0;
        pair_felt(&pair->view[f], both->x_m[f], both->felt_m[f]);
        both->is_raised[f] = gap2(both->x_m[f], both->felt_m[f]) > 0.0f;
        here->at = pair->servo[f].contact;
        find_ways(here);
    }
    both->free = both->place[0].free + both->place[1].free;
    if (pair->is_following) predict(both, pair);
    return 1;
}

/* cost: at most the evaluations and the looks that the tick has left. */
int haptable_pair_settle(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                         const float* const finger_m[HAPTABLE_FINGERS]) {
    struct both both;
    const int count = pair_count(tables->law);
    const int is_first = pair->evaluations == 0 && !pair->view[0].is_solved;
    const int most = is_first ? HAPTABLE_PAIR_EVALUATIONS - 2 : HAPTABLE_PAIR_EVALUATIONS;
    float most_j = HAPTABLE_MOST;
    both.tables = tables;
    both.x_m = finger_m;
    both.hessian_j = pair->follow.curvature_j;
    both.z = pair->follow.slope;
    both.is_given_up = both.is_foreseen = both.is_reused = 0;
    both.is_late = !is_first;
    if (!begin_both(&both, pair)) return 0;
    while (pair->evaluations < most) {
        int rests;
        if (!evaluate(&both, count, pair)) return 0;
        if (both.is_foreseen && !both.meeting.is_near) {
            rests = reuse(&both, pair);
            if (rests != 0) return rests > 0;
        }
        both.is_foreseen = 0;
        put_slopes(&both, count, &pair->net);
        rests = go_on(&both, pair, most_j);
        if (rests != 0) return rests > 0;
        most_j = both.energy_j;
    }
    return 0;
}

/* ---- one alone ------------------------------------------------------------------------------------------------ */

static void evaluate_alone(struct haptable_pair_view* view, const struct haptable_contact* at, const float x_m[3],
                           enum haptable_energy_terms terms, struct haptable_energy* energy) {
    ++view->tracked;
    view->tables->energy(&view->model, at, x_m, terms, energy);
}

/* The curvature by the ways, factored. Returns 0 where it is not positive definite. */
static int curve_alone(const struct place* here, const float hessian_j[3], float h[MOST_FREE][MOST_FREE]) {
    const float* way = here->way[0];
    h[0][0] = hessian_j[0];
    h[1][0] = hessian_j[1];
    h[1][1] = hessian_j[2];
    if (here->free == 1)
        h[0][0] =
            way[0] * way[0] * hessian_j[0] + 2.0f * way[0] * way[1] * hessian_j[1] + way[1] * way[1] * hessian_j[2];
    return factor_curvature(h, here->free == 1 ? 1 : 2);
}

/* -H^-1 b of the ways, b by alpha_1 and alpha_2, as a change of these. */
static void solve_alone(const struct place* here, float h[MOST_FREE][MOST_FREE], const float b[2], float d[2]) {
    const float* way = here->way[0];
    float step[MOST_FREE];
    step[0] = -b[0];
    step[1] = -b[1];
    if (here->free == 1) step[0] = -(way[0] * b[0] + way[1] * b[1]);
    step[2] = step[3] = 0.0f;
    if (here->free == 1) step[1] = 0.0f;
    solve_curvature(h, step);
    d[0] = here->free == 1 ? step[0] * way[0] : step[0];
    d[1] = here->free == 1 ? step[0] * way[1] : step[1];
}

/* As a minimum goes with its finger. */
static void put_sensitivity(const struct place* here, float h[MOST_FREE][MOST_FREE],
                            const struct haptable_energy* energy, struct haptable_servo* servo) {
    int c;
    for (c = 0; c < 3; ++c) {
        const float b[2] = {energy->load_gradient_n[0][c], energy->load_gradient_n[1][c]};
        float d[2];
        solve_alone(here, h, b, d);
        servo->sensitivity_per_m[0][c] = d[0];
        servo->sensitivity_per_m[1][c] = d[1];
    }
}

/* 1 where E does not fall over the edge where the place is; else it is on the patch across. */
static int rests_on_edge(struct haptable_pair_view* view, const float x_m[3], const float load_n[3],
                         struct place* here) {
    const struct haptable_model* model = &view->model;
    const uint16_t* vertex = model->patch[here->at.patch];
    const uint16_t across = model->neighbour[here->at.patch][here->corner];
    struct haptable_contact at = here->at;
    struct haptable_energy energy;
    int opposite = 0;
    int k;
    if (across == HAPTABLE_NONE) return 1;
    at.patch = across;
    vec_zero(at.alpha);
    for (k = 0; k < 3; ++k)
        if (here->at.alpha[k] > 0.0f) at.alpha[corner_of(model, across, vertex[k])] = here->at.alpha[k];
    vec_copy(load_n, energy.load_n);
    evaluate_alone(view, &at, x_m, HAPTABLE_ENERGY_GRADIENT, &energy);
    (void)feature_of(at.alpha, &opposite);
    if (!(slope_towards(at.alpha, energy.gradient_j, opposite) < 0.0f)) return 1;
    return !go_to(here, across, at.alpha);
}

/* The load after the step d to `to`, to first order where that does. */
static void load_alone(struct haptable_pair_view* view, const float x_m[3], const float d[2],
                       struct haptable_energy* energy, const struct haptable_contact* from,
                       struct haptable_contact* to) {
    const float most = LOAD_CORRECTION * LOAD_CORRECTION;
    float change[3] = {0.0f, 0.0f, 0.0f};
    vec_add_scaled(d[0], energy->load_gradient_n[0], change);
    vec_add_scaled(d[1], energy->load_gradient_n[1], change);
    if (vec_dot(change, change) <= most * vec_dot(energy->load_n, energy->load_n) &&
        gap2(from->god_object_m, to->god_object_m) <= most * gap2(x_m, to->god_object_m))
        vec_add_scaled(1.0f, change, energy->load_n);
    else
        evaluate_alone(view, to, x_m, HAPTABLE_ENERGY_LOAD, energy);
    vec_copy(energy->load_n, to->load_n);
}

/* Where the finger's own motion is foreseen to take it. */
static void predict_alone(const struct haptable_servo* servo, const float x_m[3], struct place* here,
                          const struct haptable_model* model) {
    float motion_m[3];
    float d[2];
    vec_sub(x_m, servo->finger_m, motion_m);
    d[0] = vec_dot(servo->sensitivity_per_m[0], motion_m);
    d[1] = vec_dot(servo->sensitivity_per_m[1], motion_m);
    predict_place(model, d, here);
}

/* cost: HAPTABLE_PAIR_TRACKED energies: two a step, as its patch is seen across an edge, and a load. */
int haptable_pair_track(struct haptable_pair_view* view, struct haptable_servo* servo, const float x_m[3], int steps,
                        struct haptable_contact* at) {
    struct place here;
    float most_j = HAPTABLE_MOST;
    here.at = *at;
    find_ways(&here);
    if (here.free > 0) predict_alone(servo, x_m, &here, &view->model);
    for (; steps > 0; --steps) {
        float h[MOST_FREE][MOST_FREE];
        struct haptable_energy energy;
        struct haptable_contact to;
        float d[2];
        float part;
        int ends;
        if (here.free == 0) return -1;
        evaluate_alone(view, &here.at, x_m, HAPTABLE_ENERGY_ALL, &energy);
        if (!(energy.energy_j <= most_j)) return -1;
        most_j = energy.energy_j;
        here.slope.first_j[0] = energy.gradient_j[0];
        here.slope.first_j[1] = energy.gradient_j[1];
        open_ways(&here);
        if (!curve_alone(&here, energy.hessian_j, h)) return -1;
        solve_alone(&here, h, energy.gradient_j, d);
        part = part_within(here.at.alpha, d, &ends);
        to = here.at;
        move_place(&view->model, d, part, ends, &to);
        if (part == 1.0f && is_small(d)) {
            if (here.free == 1 && !rests_on_edge(view, x_m, energy.load_n, &here)) {
                find_ways(&here);
                continue;
            }
            put_sensitivity(&here, h, &energy, servo);
            load_alone(view, x_m, d, &energy, &here.at, &to);
            *at = to;
            return 1;
        }
        here.at = to;
        vec_copy(energy.load_n, here.at.load_n);
        find_ways(&here);
        here.is_held = part == 0.0f;
    }
    *at = here.at;
    pair_keep_known(servo);
    return 0;
}
