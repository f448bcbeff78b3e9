/* SPDX-License-Identifier: MIT
 *
 * E(g) = 1/2 u^T C(g)^-1 u, downhill over the surface by all points at once: y_i = g_i + sum_j C_ij (f_j - f*_j)
 *
 * f* is the load that the surface bears without sliding: along the normal, or with friction within its cone. y is where
 * the god-objects of a flat surface would rest, and each goes to the point of the surface nearest to it. Where E would
 * grow, half of that way is tried, and then none: E only falls while the hand rests, and the force at fixed god-objects
 * is minus its gradient by the pose, so that closed loops of the pose gain nothing.
 */
#include "haptable_contact.h"
#include "haptable_pair_terms.h"
#include "haptable_points.h"
#include "haptable_surface.h"

/* Points that would move by less rest: this part of tolerance_m. */
#define REST 0.25f

/* A fall of E below this part of it is rounding. */
#define LEAST_FALL 1e-7f

/* -dE/db of every point that presses, by its alpha_1 and alpha_2: e_b . f_i + f_i . (1/2 C_ii,b f_i + sum_j C_ij,b
 * f_j).
 */
static void find_falls(const struct haptable_points_model* of, void* state, float (*fall_j)[2]) {
    const struct haptable_pair_model* pair = of->pair;
    const struct haptable_servo* servo = haptable_points_servos(of, state);
    const struct haptable_point* point = haptable_points_in(of, state);
    for (uint32_t i = 0; i < of->count; ++i) {
        const struct haptable_point* at = &point[i];
        struct haptable_pair_point own;
        struct haptable_pair_slope slope;
        if (!at->presses) continue;
        pair->bend->open(pair->model, &at->at, servo[i].finger_m, &own);
        pair->bend->slope(pair->model, &at->at, &own, at->load_n, 0, &slope);
        fall_j[i][0] = -slope.first_j[0];
        fall_j[i][1] = -slope.first_j[1];
        for (uint32_t j = 0; j < i; ++j) {
            float q[HAPTABLE_PAIR_CONTROLS], r[HAPTABLE_PAIR_CONTROLS];
            if (!point[j].presses) continue;
            of->pull(pair, &at->place, &point[j].place, at->load_n, point[j].load_n, q, r);
            haptable_pair_add_slope(pair->law, &at->at, q, fall_j[i]);
            haptable_pair_add_slope(pair->law, &point[j].at, r, fall_j[j]);
        }
    }
}

/* The vector t of a patch's plane with e_b . t = fall_b. */
static void along_plane(const float e[2][3], const float fall_j[2], float t[3]) {
    const float aa = vec_length2(e[0]);
    const float ab = vec_dot(e[0], e[1]);
    const float bb = vec_length2(e[1]);
    const float det = aa * bb - ab * ab;
    vec_zero(t);
    if (!(det > 1e-6f * aa * bb)) return;
    vec_add_scaled((bb * fall_j[0] - ab * fall_j[1]) / det, e[0], t);
    vec_add_scaled((aa * fall_j[1] - ab * fall_j[0]) / det, e[1], t);
}

/* What makes a point slide: minus the slope of E along the surface, N, less what friction bears. */
static void excess_of(const struct haptable_points_model* of, const struct haptable_point point[], uint32_t i,
                      const float fall_j[2], float excess_n[3]) {
    const struct haptable_model* model = of->pair->model;
    const struct haptable_point* at = &point[i];
    float e[2][3], normal[3];
    patch_frame(model, at->at.patch, e[0], e[1], normal);
    const float length2 = vec_length2(normal);
    vec_scale(vec_inverse_root(length2 > HAPTABLE_ROOT_LEAST ? length2 : HAPTABLE_ROOT_LEAST), normal);
    const float along = vec_dot(at->load_n, normal);
    if (of->pair->bend) {
        along_plane((const float(*)[3])e, fall_j, excess_n);
    } else {
        vec_copy(at->load_n, excess_n);
        vec_add_scaled(-along, normal, excess_n);
    }
    if (!model->frictionless) return;
    const float tangent2 = vec_length2(excess_n);
    const float bound = model->static_friction * along;
    if (along >= 0.0f) return;
    if (tangent2 <= bound * bound)
        vec_zero(excess_n);
    else
        vec_scale(1.0f + model->kinetic_friction * along * vec_inverse_root(tangent2), excess_n);
}

/* To where the surface would meet a point that is out of T, from where its god-object is. */
static void way_out(const struct haptable_points_model* of, void* state, uint32_t i, float way_m[3]) {
    const struct haptable_point* point = &haptable_points_in(of, state)[i];
    float lowered_m[3];
    haptable_points_lowered(of, state, i, lowered_m);
    vec_sub(haptable_points_servos(of, state)[i].finger_m, lowered_m, way_m);
    vec_sub(way_m, point->at.god_object_m, way_m);
}

enum going { NONE_GOES, NONE_THAT_PRESSES_GOES, SOME_GO };

/* How far each point would go, and whether one goes farther than it may rest. before: way_m is 0. */
static enum going foresee(const struct haptable_points_model* of, void* state, float (*way_m)[3]) {
    struct haptable_point* point = haptable_points_in(of, state);
    const struct haptable_points* all = haptable_points_of(of, state);
    float load_n[HAPTABLE_POINTS][3] = {{0.0f}};
    float excess_n[HAPTABLE_POINTS][3] = {{0.0f}};
    float falls_j[HAPTABLE_POINTS][2] = {{0.0f}};
    const float rest_m = REST * of->pair->model->tolerance_m;
    float fall_j = 0.0f;
    enum going goes = NONE_GOES;
    if (of->pair->bend) find_falls(of, state, falls_j);
    for (uint32_t i = 0; i < of->count; ++i) {
        if (!point[i].is_inside) continue;
        if (point[i].presses)
            excess_of(of, point, i, falls_j[i], excess_n[i]);
        else
            way_out(of, state, i, way_m[i]);
    }
    for (uint32_t i = 0; i < of->count; ++i) {
        vec_copy(point[i].load_n, load_n[i]);
        vec_copy(excess_n[i], point[i].load_n);
    }
    for (uint32_t i = 0; i < of->count; ++i) {
        float with_m[3]; /* as far as the surface goes with those that slide */
        if (!point[i].is_inside) continue;
        if (point[i].presses && !(vec_length2(excess_n[i]) > 0.0f)) continue; /* it holds the surface */
        haptable_points_lowered(of, state, i, with_m);
        vec_add(way_m[i], with_m, way_m[i]);
        if (point[i].presses) fall_j += 0.5f * vec_dot(way_m[i], excess_n[i]);
    }
    for (uint32_t i = 0; i < of->count; ++i) {
        vec_copy(load_n[i], point[i].load_n);
        if (point[i].presses && !(fall_j > LEAST_FALL * all->energy_j)) vec_zero(way_m[i]);
        if (!(vec_length2(way_m[i]) > rest_m * rest_m)) continue;
        if (point[i].presses)
            goes = SOME_GO;
        else if (goes == NONE_GOES)
            goes = NONE_THAT_PRESSES_GOES;
    }
    return goes;
}

/* Goes that part of the way from where each was, and T begins as it was. The walks of a tick share HAPTABLE_WALK_STEPS:
 * one that needs more ends on the surface where it is. */
static void go(const struct haptable_points_model* of, void* state, uint32_t count, const struct haptable_point from[],
               const float (*way_m)[3], float part) {
    struct haptable_point* point = haptable_points_in(of, state);
    for (uint32_t i = 0; i < count; ++i) {
        float to_m[3];
        int steps = HAPTABLE_WALK_STEPS - HAPTABLE_POINTS_WALK_STEPS;
        point[i].presses = from[i].presses;
        if (!point[i].presses) vec_zero(point[i].load_n);
        if (!point[i].is_inside || !(vec_length2(way_m[i]) > 0.0f)) continue;
        point[i].at = from[i].at;
        vec_copy(from[i].at.god_object_m, to_m);
        vec_add_scaled(part, way_m[i], to_m);
        (void)haptable_contact_slide(of->pair->model, to_m, &point[i].at, &steps);
        point[i].is_known = 0;
    }
}

/* To where each was, with its load. */
static void go_back(const struct haptable_points_model* of, void* state, uint32_t count,
                    const struct haptable_point from[]) {
    haptable_points_take_back(of, state);
    for (uint32_t i = 0; i < count; ++i) haptable_points_in(of, state)[i] = from[i];
    haptable_points_factor(of, state);
}

/* One that pressed has no load, and is inside: E has fallen, but not downhill. */
static int has_lost(const struct haptable_points_model* of, void* state, uint32_t count,
                    const struct haptable_point from[]) {
    const struct haptable_point* point = haptable_points_in(of, state);
    for (uint32_t i = 0; i < count; ++i)
        if (from[i].presses && !point[i].presses && haptable_point_depth(of, state, i) > of->pair->model->tolerance_m)
            return 1;
    return 0;
}

/* One step downhill, or none. */
static void lower(const struct haptable_points_model* of, void* state) {
    const struct haptable_point* point = haptable_points_in(of, state);
    struct haptable_points* all = haptable_points_of(of, state);
    struct haptable_point from[HAPTABLE_POINTS];
    float way_m[HAPTABLE_POINTS][3] = {{0.0f}};
    const uint32_t count = of->count;
    float part = 1.0f;
    const enum going goes = foresee(of, state, way_m);
    if (goes == NONE_GOES) return;
    for (uint32_t i = 0; i < count; ++i) from[i] = point[i];
    haptable_points_keep(of, state);
    /* E is of those that press: without them it stays, to rounding. The hand has paid for those that left T, too: their
     * loads pulled where their god-objects were. */
    const int trials = goes == SOME_GO ? HAPTABLE_POINTS_TRIALS : 1;
    const float stored_j = all->energy_j;
    const float paid_j = all->paid_j > stored_j ? all->paid_j : stored_j;
    const float most_j = goes == SOME_GO ? paid_j : (1.0f + LEAST_FALL) * paid_j;
    for (int trial = 0; trial < trials; ++trial) {
        go(of, state, count, from, (const float(*)[3])way_m, part);
        if (haptable_points_solve(of, state, HAPTABLE_POINTS_TRIAL_SETS) && all->energy_j <= most_j &&
            !has_lost(of, state, count, from))
            return;
        part *= 0.5f;
    }
    go_back(of, state, count, from);
    all->energy_j = stored_j;
}

void haptable_points_settle(const struct haptable_points_model* of, void* state) {
    const struct haptable_point* point = haptable_points_in(of, state);
    lower(of, state);
    for (uint32_t i = 0; i < of->count; ++i)
        if (point[i].is_inside) haptable_point_sink(of, state, i);
}

void haptable_points_tick(const struct haptable_points_model* of, void* state) {
    struct haptable_points* all = haptable_points_of(of, state);
    all->sets = 0;
    all->paid_j = 0.0f;
    all->count = 0; /* no tick goes by the factor of another */
    /* Where T was not found: loads of what it is now, or of the deepest point alone. */
    if (!haptable_points_solve(of, state, HAPTABLE_POINTS_SETS) && !haptable_points_solve(of, state, 1))
        haptable_points_press_by_one(of, state);
    if (of->settle) of->settle(of, state);
    if (all->sets > all->most_sets) all->most_sets = all->sets;
}
