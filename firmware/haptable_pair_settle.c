/* SPDX-License-Identifier: MIT
 *
 * (g_1, g_2) = argmin E over both places at once, by Newton's steps in the four area coordinates that the two
 * god-objects move by: haptable_pair_terms.h
 *
 * As one finger's god-object does, the two follow their minimum to first order in both motions, and Newton's step, of
 * both, corrects that: so no order of the fingers is in what they feel. A step ends at the border of a patch; from
 * there it goes on into the patch across, along the edge or back, whatever leads down. Where E does not bend upwards,
 * or that takes too long, haptable_pair_servo.c lets them move one after the other.
 */
#include "haptable_bounds.h"
#include "haptable_compliance.h"
#include "haptable_contact.h"
#include "haptable_pair_terms.h"
#include "haptable_patch.h"

/* alpha_1 and alpha_2 of the first finger, then of the second. */
#define COORDINATES 4

/* A finger's place. */
struct place {
    struct haptable_contact at;
    struct haptable_pair_point point;
    struct haptable_pair_slope slope;
    struct pair_link link;
    struct pair_varied varied;
    float felt_m[3]; /* where its dent ends */
    float along[2];  /* of an edge where it is: a change of alpha_1, alpha_2 */
    int free;        /* coordinates by which it may move: 2 within a patch, 1 along an edge, 0 on a vertex */
    int corner;      /* of an edge: opposite to it; of a vertex: there */
    int is_held;     /* 1: it stays on its edge or vertex, as its patch was tried */
};

/* A tick of both. */
struct both {
    const struct haptable_pair_model* tables;
    struct haptable_pair* pair;
    const float* const* x_m;
    struct place place[HAPTABLE_FINGERS];
    struct pair_system system;
    float x[9];
    float energy_j;
    float gradient_j[COORDINATES];
    int is_late;     /* 1: both were looked at already */
    int is_foreseen; /* 1: within the patches whose curvature an earlier tick took */
    int is_reused;   /* 1: that one told the step */
};

/* ---- where they are free to move -------------------------------------------------------------------------------- */

static void put_along(int from, int to, float along[2]) {
    along[0] = (float)(to == 1) - (float)(from == 1);
    along[1] = (float)(to == 2) - (float)(from == 2);
}

static void find_freedom(struct place* here) {
    here->corner = here->is_held = 0;
    const enum place_on_patch feature = feature_of(here->at.alpha, &here->corner);
    here->free = feature == INSIDE ? 2 : (feature == ON_EDGE ? 1 : 0);
    if (here->free == 1) put_along(next_corner(here->corner), previous_corner(here->corner), here->along);
}

/* dE by alpha_c towards corner c, the others giving way in proportion. */
static float slope_towards(const struct place* here, int c) {
    const float* gradient_j = here->slope.first_j;
    return (c == 0 ? 0.0f : gradient_j[c - 1]) - here->at.alpha[1] * gradient_j[0] - here->at.alpha[2] * gradient_j[1];
}

/* From an edge into its patch, or from a vertex along an edge, where E falls there. */
static void open_freedom(struct place* here) {
    const int one = next_corner(here->corner);
    const int two = previous_corner(here->corner);
    if (here->free == 2 || here->is_held) return;
    if (here->free == 1) {
        if (slope_towards(here, here->corner) < 0.0f) here->free = 2;
    } else {
        const float down_one = slope_towards(here, one);
        const float down_two = slope_towards(here, two);
        if (!(down_one < 0.0f || down_two < 0.0f)) return;
        here->free = 1;
        put_along(here->corner, down_one < down_two ? one : two, here->along);
    }
}

/* b . change of the free coordinates, which come first; 0 of the others. */
static void keep_free(const struct place* here, float* one, float* two) {
    if (here->free == 2) return;
    *one = here->free == 1 ? here->along[0] * *one + here->along[1] * *two : 0.0f;
    *two = 0.0f;
}

/* ---- Newton's step ---------------------------------------------------------------------------------------------- */

/* Less than this part of a pivot is its rounding. */
#define PIVOT_ROUNDING 1e-5f

/* 1 / pivot; 0 where that is not positive beyond its rounding. */
static float inverse_of(float pivot, float whole) {
    return pivot > PIVOT_ROUNDING * whole && whole > 0.0f ? 1.0f / pivot : 0.0f;
}

/* Takes a matrix to the free coordinates, from its lower half. */
static void reduce(const struct place place[HAPTABLE_FINGERS], float h[COORDINATES][COORDINATES]) {
    for (int i = 0; i < COORDINATES; ++i)
        for (int f = 0; f < i; ++f) h[f][i] = h[i][f];
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        for (int i = 0; i < COORDINATES; ++i) keep_free(&place[f], &h[i][2 * f], &h[i][2 * f + 1]);
        for (int i = 0; i < COORDINATES; ++i) keep_free(&place[f], &h[2 * f][i], &h[2 * f + 1][i]);
    }
}

/* H = L D L^T in place by its lower half, of the free coordinates: 1 / D on the diagonal, 0 of those that are not free.
 * Returns 0 where H is not positive definite beyond rounding. Every number is a statement of its own: loops would cost
 * more than what they do. */
static int factor(const struct place place[HAPTABLE_FINGERS], float h[COORDINATES][COORDINATES]) {
    if (place[0].free < 2 || place[1].free < 2) reduce(place, h);
    h[0][0] = inverse_of(h[0][0], h[0][0]);
    float l0 = h[1][0] * h[0][0];
    h[1][1] = inverse_of(h[1][1] - l0 * h[1][0], h[1][1]);
    h[1][0] = l0;
    h[2][1] -= h[2][0] * h[1][0];
    l0 = h[2][0] * h[0][0];
    float l1 = h[2][1] * h[1][1];
    h[2][2] = inverse_of(h[2][2] - l0 * h[2][0] - l1 * h[2][1], h[2][2]);
    h[2][0] = l0;
    h[2][1] = l1;
    h[3][1] -= h[3][0] * h[1][0];
    h[3][2] -= h[3][0] * h[2][0] + h[3][1] * h[2][1];
    l0 = h[3][0] * h[0][0];
    l1 = h[3][1] * h[1][1];
    const float l2 = h[3][2] * h[2][2];
    h[3][3] = inverse_of(h[3][3] - l0 * h[3][0] - l1 * h[3][1] - l2 * h[3][2], h[3][3]);
    h[3][0] = l0;
    h[3][1] = l1;
    h[3][2] = l2;
    for (int i = 0; i < COORDINATES; ++i)
        if (h[i][i] == 0.0f && i % 2 < place[i / 2].free) return 0;
    return 1;
}

/* d = H^-1 b: changes of the area coordinates. before: factor, of places with the same freedom. */
static void solve(const struct place place[HAPTABLE_FINGERS], float (*h)[COORDINATES], const float b[COORDINATES],
                  float d[COORDINATES]) {
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        d[2 * f] = b[2 * f];
        d[2 * f + 1] = b[2 * f + 1];
        keep_free(&place[f], &d[2 * f], &d[2 * f + 1]);
    }
    d[1] -= h[1][0] * d[0];
    d[2] -= h[2][0] * d[0] + h[2][1] * d[1];
    d[3] -= h[3][0] * d[0] + h[3][1] * d[1] + h[3][2] * d[2];
    d[3] *= h[3][3];
    d[2] = d[2] * h[2][2] - h[3][2] * d[3];
    d[1] = d[1] * h[1][1] - h[2][1] * d[2] - h[3][1] * d[3];
    d[0] = d[0] * h[0][0] - h[1][0] * d[1] - h[2][0] * d[2] - h[3][0] * d[3];
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        if (place[f].free != 1) continue;
        d[2 * f + 1] = d[2 * f] * place[f].along[1];
        d[2 * f] *= place[f].along[0];
    }
}

/* ---- an evaluation ---------------------------------------------------------------------------------------------- */

/* v of both, and the energy, of places whose own terms are known. Returns 0 where N is lifted, or the tick has read all
 * blocks that it may. */
static int solve_places(struct both* both) {
    struct haptable_pair* pair = both->pair;
    struct place* here = both->place;
    if (pair_is_dear(both->tables, &pair->net, here[0].at.patch, here[1].at.patch) &&
        pair->net.reads++ >= HAPTABLE_PAIR_READS)
        return 0;
    haptable_pair_read(both->tables, &pair->net, here[0].at.patch, here[1].at.patch);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        haptable_pair_tell(&pair->view[f], &here[1 - f].at, &here[1 - f].point.own);
    haptable_pair_put_rows(both->tables, pair, 0, here[0].at.patch);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        haptable_pair_link(&pair->view[f], &here[f].at, (const float(*)[9])pair->view[f].rows[0].x, here[f].point.e,
                           &here[f].link);
    pair_cross_of(&here[0].link, both->x);
    if (haptable_pair_solve(&pair->view[0], &here[0].point.own, both->x, &both->system) < 1.0f) return 0;
    both->energy_j =
        0.5f * (vec_dot(here[0].point.own.s, both->system.v[0]) + vec_dot(here[1].point.own.s, both->system.v[1]));
    return 1;
}

/* v_1 . C_kl v_2 of all controls. */
static void put_mixed(const struct both* both, float mixed_j[HAPTABLE_PAIR_CONTROLS][HAPTABLE_PAIR_CONTROLS]) {
    const int count = pair_count(both->tables->law);
    const float* one = both->system.v[0];
    const float* two = both->system.v[1];
    const float* block = both->pair->net.block[0];
    float p[9];
    for (int k = 0; k < 3; ++k) {
        p[3 * k] = one[k] * two[0];
        p[3 * k + 1] = one[k] * two[1];
        p[3 * k + 2] = one[k] * two[2];
    }
    for (int k = 0; k < count; ++k)
        for (int l = 0; l < count; ++l, block += 9)
            mixed_j[k][l] = p[0] * block[0] + p[1] * block[1] + p[2] * block[2] + p[3] * block[3] + p[4] * block[4] +
                            p[5] * block[5] + p[6] * block[6] + p[7] * block[7] + p[8] * block[8];
}

/* The gradient of both apart from each other. */
static void put_gradient(struct both* both, float mixed_j[HAPTABLE_PAIR_CONTROLS][HAPTABLE_PAIR_CONTROLS]) {
    const struct place* here = both->place;
    const int count = pair_count(both->tables->law);
    float q[HAPTABLE_FINGERS][HAPTABLE_PAIR_CONTROLS];
    for (int k = 0; k < count; ++k) {
        q[0][k] = pair_sum_numbers(count, here[1].link.weight, mixed_j[k], 1);
        q[1][k] = pair_sum_numbers(count, here[0].link.weight, &mixed_j[0][k], HAPTABLE_PAIR_CONTROLS);
    }
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        float* gradient_j = &both->gradient_j[2 * f];
        pair_coupled_slope(count, &here[f].link, q[f], gradient_j);
        gradient_j[0] = here[f].slope.first_j[0] - gradient_j[0];
        gradient_j[1] = here[f].slope.first_j[1] - gradient_j[1];
    }
}

/* v_1 . X_bc v_2 by coordinates b of the first and c of the second. */
static void put_mixed_bend(const struct both* both, float mixed_j[HAPTABLE_PAIR_CONTROLS][HAPTABLE_PAIR_CONTROLS],
                           float bend_j[2][2]) {
    const int count = pair_count(both->tables->law);
    const float per_m = 1.0f / both->tables->meeting_m;
    const struct pair_link* one = &both->place[0].link;
    const struct pair_link* two = &both->place[1].link;
    const float* first_j = both->place[0].varied.coupled_j;
    const float* second_j = both->place[1].varied.coupled_j;
    for (int c = 0; c < 2; ++c) {
        float row[HAPTABLE_PAIR_CONTROLS];
        for (int b = 0; b < count; ++b) row[b] = pair_sum_numbers(count, two->slope[c], mixed_j[b], 1);
        for (int b = 0; b < 2; ++b) bend_j[b][c] = pair_sum_numbers(count, one->slope[b], row, 1);
    }
    if (!(one->near > 0.0f)) return;
    for (int b = 0; b < 2; ++b)
        for (int c = 0; c < 2; ++c) {
            const float near_bend =
                2.0f * per_m * per_m * vec_dot(both->place[0].point.e[b], both->place[1].point.e[c]);
            const float share_bend =
                -2.0f * HAPTABLE_PAIR_MEETING * (one->near_slope[b] * two->near_slope[c] + one->near * near_bend);
            bend_j[b][c] = one->share * bend_j[b][c] + one->share_slope[b] * second_j[c] +
                           two->share_slope[c] * first_j[b] + share_bend * first_j[2];
        }
}

/* Gradient and curvature of both, and how v changes, z. */
static void put_slopes(struct both* both, float mixed_j[HAPTABLE_PAIR_CONTROLS][HAPTABLE_PAIR_CONTROLS]) {
    struct haptable_pair* pair = both->pair;
    float(*h)[COORDINATES] = pair->follow.curvature_j;
    float(*z)[HAPTABLE_FINGERS][3] = pair->follow.slope;
    float y[COORDINATES][HAPTABLE_FINGERS][3], bend_j[2][2];
    haptable_pair_put_rows(both->tables, pair, 1, both->place[1].at.patch);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        haptable_pair_vary(&here->link, both->system.v[f], both->system.v[1 - f], &here->slope, &here->varied);
        open_freedom(here);
    }
    put_mixed_bend(both, mixed_j, bend_j);
    for (int i = 0; i < COORDINATES; ++i) {
        const struct place* here = &both->place[i / 2];
        const int b = i % 2;
        both->gradient_j[i] = here->slope.first_j[b];
        vec_copy(here->slope.y[b], y[i][i / 2]);
        vec_zero(y[i][1 - i / 2]);
        vec_sub(y[i][1 - i / 2], here->varied.back[b], y[i][1 - i / 2]);
        pair_solve_slope(&pair->view[0], &both->system, y[i], z[i]);
        h[i][i - b] = here->slope.second_j[b];
        h[i][i] = here->slope.second_j[2 * b];
        for (int j = 0; j < 2 && i > 1; ++j) h[i][j] = -bend_j[j][b];
        for (int j = 0; j <= i; ++j) h[i][j] += vec_dot(y[i][0], z[j][0]) + vec_dot(y[i][1], z[j][1]);
    }
}

/* ---- steps ------------------------------------------------------------------------------------------------------ */

/* Newton's step may be this much of a patch where it ends a tick: its own error is of the order of its square. One
 * finger's is held to less (HAPTABLE_CORRECTION): of two an evaluation is dear, and loops give no more with this. */
#define CORRECTION 1e-2f

/* A step by the curvature of an earlier tick ends a tick where it is this small: what it leaves is a part of it. */
#define REUSED_CORRECTION 2e-3f

/* v is taken to first order where neither it nor u changes by more than this part, as in haptable_least_energy.c; by
 * slopes of an earlier tick, which may be a quarter off, where that leaves as little: the square of it. */
#define LOAD_CORRECTION 2.5e-3f
#define REUSED_LOAD_CORRECTION 2.5e-5f

/* d[0]: as the others change. */
static void put_change(const float d[2], float change[3]) {
    change[0] = -(d[0] + d[1]);
    change[1] = d[0];
    change[2] = d[1];
}

static int leads_off(const struct haptable_contact* at, const float change[3]) {
    for (int c = 0; c < 3; ++c)
        if (at->alpha[c] == 0.0f && change[c] < 0.0f) return 1;
    return 0;
}

static int is_small(const float d[COORDINATES], float most) {
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        float change[3];
        put_change(&d[2 * f], change);
        for (int c = 0; c < 3; ++c)
            if (!(vec_magnitude(change[c]) < most)) return 0;
    }
    return 1;
}

/* Both where a step of both leads, at most to the first border. Returns how much of it that is; part: of each. */
static float step_places(const struct both* both, const float d[COORDINATES],
                         struct haptable_contact to[HAPTABLE_FINGERS], float part[HAPTABLE_FINGERS]) {
    float change[HAPTABLE_FINGERS][3];
    float least = 1.0f;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        put_change(&d[2 * f], change[f]);
        part[f] = leads_off(&both->place[f].at, change[f])
                      ? 0.0f
                      : haptable_patch_move(both->tables->model, &both->place[f].at, change[f], 1.0f, &to[f]);
        if (part[f] < least) least = part[f];
    }
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        if (part[f] > least || part[f] == 0.0f)
            (void)haptable_patch_move(both->tables->model, &both->place[f].at, change[f], least, &to[f]);
    return least;
}

/* v of a finger after a step, to first order. Returns 0 where that does not do. */
static int step_load(const struct both* both, int f, const float d[COORDINATES], const float to_m[3], float v[3]) {
    const struct place* here = &both->place[f];
    const float part = both->is_reused ? REUSED_LOAD_CORRECTION : LOAD_CORRECTION;
    const float most = part * part;
    float change[3] = {0.0f, 0.0f, 0.0f};
    for (int i = 0; i < COORDINATES; ++i) vec_add_scaled(d[i], both->pair->follow.slope[i][f], change);
    vec_add(both->system.v[f], change, v);
    return !here->point.steps && gap2(to_m, here->at.god_object_m) <= most * vec_dot(here->point.u, here->point.u) &&
           vec_dot(change, change) <= most * vec_dot(v, v);
}

/* 1 where a finger is within its patch, or E falls off its edge or vertex nowhere; else it is on another patch. */
static int rests_across(struct both* both, int f) {
    const struct haptable_pair_view* view = &both->pair->view[f];
    struct place* here = &both->place[f];
    if (here->free == 2) return 1;
    haptable_pair_load_of(both->tables->law, here->point.own.a, both->system.v[f], here->at.load_n);
    return !haptable_contact_falls(&view->model, both->x_m[f], HAPTABLE_PAIR_LOOKS, &both->pair->looks, &here->at);
}

/* A sensitivity that moves no god-object, and tells that it rests: nobody knows how it goes with its finger alone. */
#define RESTING_PER_M 1e-12f

/* What the next tick follows by. */
static void put_follow(const struct both* both, struct haptable_pair_follow* follow) {
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        const struct place* here = &both->place[f];
        follow->patch[f] = here->at.patch;
        follow->free[f] = (uint8_t)here->free;
        if (!both->tables->law->is_stiffness) continue;
        for (int i = 0; i < 6; ++i) follow->a[f][i] = here->point.own.a[i];
        for (int i = 0; i < 2; ++i) vec_copy(here->slope.a_v[i], follow->a_v[2 * f + i]);
    }
}

/* The tick's places and v. */
static void put_rest(struct both* both, float v[HAPTABLE_FINGERS][3], float energy_j) {
    struct haptable_pair* pair = both->pair;
    if (!both->is_reused) put_follow(both, &pair->follow);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct haptable_servo* servo = &pair->servo[f];
        servo->contact = both->place[f].at;
        vec_copy(both->x_m[f], servo->finger_m); /* it stays, and so does a god-object that rests */
        vec_zero(servo->sensitivity_per_m[0]);
        vec_zero(servo->sensitivity_per_m[1]);
        servo->sensitivity_per_m[0][0] = RESTING_PER_M;
        vec_copy(v[f], pair->view[f].v);
        pair->view[f].is_solved = 1;
    }
    pair->energy_j = energy_j;
    pair->is_following = both->is_reused ? (uint8_t)(pair->is_following + 1) : 1;
}

/* The tick's end, where the step d is small. Returns 1 where the two rest, 0 where one goes on over an edge, -1 where
 * they cannot rest together. */
static int end(struct both* both, const float d[COORDINATES], float fall_j,
               const struct haptable_contact to[HAPTABLE_FINGERS]) {
    const struct haptable_pair_model* tables = both->tables;
    struct haptable_pair* pair = both->pair;
    struct place* here = both->place;
    const struct haptable_contact* const at[HAPTABLE_FINGERS] = {&here[0].at, &here[1].at};
    const struct haptable_pair_own* const own[HAPTABLE_FINGERS] = {&here[0].point.own, &here[1].point.own};
    float v[HAPTABLE_FINGERS][3];
    int touches[HAPTABLE_FINGERS];
    int is_known = 1;
    int rests = 1;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) rests = rests_across(both, f) && rests;
    if (pair->looks >= HAPTABLE_PAIR_LOOKS) return -1;
    if (!rests) {
        for (int f = 0; f < HAPTABLE_FINGERS; ++f) find_freedom(&here[f]);
        return 0;
    }
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) is_known = step_load(both, f, d, to[f].god_object_m, v[f]) && is_known;
    if (!is_known) {
        for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
            here[f].at = to[f];
            tables->law->own(tables->model, at[f], here[f].felt_m, &here[f].point.own);
        }
        if (!solve_places(both)) return -1;
        for (int f = 0; f < HAPTABLE_FINGERS; ++f) vec_copy(both->system.v[f], v[f]);
    }
    haptable_pair_touch(pair, at, both->x_m, own, both->x, v, touches);
    if (touches[0] != touches[1]) {
        pair->touches[touches[0] ? 1 : 0] = 0;
        return -1;
    }
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        here[f].at = to[f];
        haptable_pair_load_of(tables->law, own[f]->a, v[f], here[f].at.load_n);
        if (both->is_late && !haptable_contact_surely_presses(tables->model, at[f], both->x_m[f])) return -1;
    }
    put_rest(both, v, both->energy_j + (is_known ? fall_j : 0.0f));
    return 1;
}

/* Newton's step after an evaluation. Returns as end does, or 0 where another evaluation is to be made. */
static int step(struct both* both) {
    struct haptable_contact to[HAPTABLE_FINGERS];
    float b[COORDINATES], d[COORDINATES], part[HAPTABLE_FINGERS];
    float fall_j = 0.0f;
    for (int i = 0; i < COORDINATES; ++i) b[i] = -both->gradient_j[i];
    solve(both->place, both->pair->follow.curvature_j, b, d);
    for (int i = 0; i < COORDINATES; ++i) fall_j -= 0.5f * d[i] * b[i];
    if (both->is_reused && !is_small(d, REUSED_CORRECTION)) return 0;
    const float least = step_places(both, d, to, part);
    if (least == 1.0f && is_small(d, CORRECTION)) return end(both, d, fall_j, to);
    if (both->is_reused) return 0;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        both->place[f].at = to[f];
        find_freedom(&both->place[f]);
        both->place[f].is_held = part[f] == 0.0f; /* it led off an edge or a vertex at once */
    }
    return 0;
}

/* What both have of their slopes alone, where they are, and what couples these: a step by it. most_j: the energy
 * before. Returns as step does. */
static int evaluate(struct both* both, float most_j) {
    const struct haptable_pair_model* tables = both->tables;
    float mixed_j[HAPTABLE_PAIR_CONTROLS][HAPTABLE_PAIR_CONTROLS];
    ++both->pair->evaluations;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        tables->bend->open(tables->model, &here->at, here->felt_m, &here->point);
    }
    if (!solve_places(both)) return -1;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        tables->bend->slope(tables->model, &here->at, &here->point, both->system.v[f], 1, &here->slope);
    }
    put_mixed(both, mixed_j);
    if (both->is_foreseen && !(both->place[0].link.near > 0.0f)) {
        put_gradient(both, mixed_j);
        both->is_reused = 1;
        const int rests = step(both);
        if (rests != 0) return rests;
        both->is_reused = 0;
    }
    both->is_foreseen = 0;
    if (!(both->energy_j <= most_j)) return -1;
    put_slopes(both, mixed_j);
    if (!factor(both->place, both->pair->follow.curvature_j)) return -1;
    return step(both);
}

/* ---- a tick ----------------------------------------------------------------------------------------------------- */

/* Where a step of one is foreseen to lead: over an edge to the point of the patch there that is nearest to its end. */
static void predict_place(const struct haptable_model* model, const float d[2], struct place* here) {
    float change[3], aim_m[3];
    put_change(d, change);
    vec_copy(here->at.god_object_m, aim_m);
    if (haptable_patch_move(model, &here->at, change, 1.0f, &here->at) < 1.0f && here->free == 2) {
        const enum place_on_patch feature = feature_of(here->at.alpha, &here->corner);
        const uint16_t across = feature == ON_EDGE ? model->neighbour[here->at.patch][here->corner] : HAPTABLE_NONE;
        float edge[2][3], normal[3];
        patch_frame(model, here->at.patch, edge[0], edge[1], normal);
        vec_add_scaled(d[0], edge[0], aim_m);
        vec_add_scaled(d[1], edge[1], aim_m);
        if (across != HAPTABLE_NONE) haptable_patch_nearest(model, across, aim_m, &here->at);
    }
    find_freedom(here);
}

/* Where the fingers' motions take the minimum: -H^-1 (slopes . motions), as the loads go with these. */
static void predict(struct both* both) {
    struct haptable_pair* pair = both->pair;
    struct haptable_pair_follow* follow = &pair->follow;
    const int is_stiffness = both->tables->law->is_stiffness;
    float motion_m[HAPTABLE_FINGERS][3], by[HAPTABLE_FINGERS][3], b[COORDINATES], d[COORDINATES];
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        if (follow->patch[f] != both->place[f].at.patch || follow->free[f] != both->place[f].free) return;
        vec_sub(both->x_m[f], pair->servo[f].finger_m, motion_m[f]);
        haptable_pair_load_of(both->tables->law, follow->a[f], motion_m[f], by[f]);
    }
    for (int i = 0; i < COORDINATES; ++i) {
        b[i] = -vec_dot(follow->slope[i][0], by[0]) - vec_dot(follow->slope[i][1], by[1]);
        if (is_stiffness) b[i] -= vec_dot(follow->a_v[i], motion_m[i / 2]);
    }
    solve(both->place, follow->curvature_j, b, d);
    both->is_foreseen = pair->is_following < HAPTABLE_PAIR_REUSED;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both->place[f];
        predict_place(both->tables->model, &d[2 * f], here);
        if (here->free < 2 || follow->free[f] < 2 || here->at.patch != follow->patch[f]) both->is_foreseen = 0;
    }
}

static int may_rest(const struct haptable_pair* pair, int f) {
    const struct haptable_servo* servo = &pair->servo[f];
    return servo->contact.patch != HAPTABLE_NONE && servo->finger_known && pair->touches[f] &&
           !servo->segment.unfinished && servo->undecided_ticks == 0 && (servo->buttons & HAPTABLE_BUTTON_GRAB) == 0;
}

/* cost: at most the evaluations and the looks that the tick has left. */
int haptable_pair_settle(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                         const float* const finger_m[HAPTABLE_FINGERS], int is_late) {
    const int most = is_late ? HAPTABLE_PAIR_EVALUATIONS : HAPTABLE_PAIR_EVALUATIONS - 2;
    struct both both;
    float most_j = HAPTABLE_MOST;
    int rests = 0;
    both.tables = tables;
    both.pair = pair;
    both.x_m = finger_m;
    both.is_late = is_late;
    both.is_foreseen = both.is_reused = 0;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct place* here = &both.place[f];
        if (!may_rest(pair, f)) return 0;
        pair_felt(&pair->view[f], finger_m[f], here->felt_m);
        here->at = pair->servo[f].contact;
        find_freedom(here);
    }
    if (pair->is_following) predict(&both);
    while (rests == 0 && pair->evaluations < most) {
        rests = evaluate(&both, most_j);
        most_j = both.energy_j;
    }
    return rests > 0;
}
