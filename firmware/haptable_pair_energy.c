/* SPDX-License-Identifier: MIT
 *
 * E of both fingers over the place of the one, the other staying where it is: haptable_pair_terms.h
 */
#include "haptable_pair_terms.h"

/* What an evaluation has before the load is known. */
struct point {
    struct haptable_pair_point own;
    struct pair_coupling coupling;
};

/* The load of v: A v, or v. */
static void put_load(const struct haptable_pair_law* law, const float a[6], const float v[3], float load_n[3]) {
    if (law->is_stiffness)
        vec_symmetric_product(a, v, load_n);
    else
        vec_copy(v, load_n);
}

/* The load's slope is v's, or A_b v + A v_b. */
static void put_load_slope(const struct haptable_pair_law* law, const struct haptable_pair_point* own,
                           const struct haptable_pair_slope* slope, float load_gradient_n[2][3]) {
    int b;
    for (b = 0; b < 2; ++b) {
        put_load(law, own->own.a, slope->y[b], load_gradient_n[b]);
        if (law->is_stiffness) vec_add_scaled(1.0f, slope->a_v[b], load_gradient_n[b]);
    }
}

static void put_bend(const struct haptable_pair_view* view, const struct point* point, const struct pair_solved* solved,
                     struct haptable_pair_slope* slope, struct haptable_energy* energy) {
    vec_copy(slope->second_j, energy->hessian_j);
    pair_bend(view, &point->coupling, solved, slope->y, energy);
    put_load_slope(view->tables->law, &point->own, slope, energy->load_gradient_n);
    if (point->own.steps) forget_slope(energy);
}

static void put_energy(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                       const float finger_m[3], enum haptable_energy_terms terms, struct haptable_energy* energy) {
    const struct haptable_pair_model* tables = view->tables;
    const int is_known = terms == HAPTABLE_ENERGY_GRADIENT && !tables->law->is_stiffness; /* v: the load */
    struct haptable_pair_slope slope;
    struct pair_solved solved;
    struct point point;
    int b;
    tables->bend->open(tables->model, contact, finger_m, &point.own);
    pair_couple(view, contact, point.own.e, &point.coupling);
    if (is_known) {
        vec_copy(energy->load_n, solved.v);
        if (view->share < 1.0f) { /* the same place as another patch sees it */
            pair_set(view->share, point.coupling.x, point.coupling.x);
            pair_fade(view->share, &point.coupling);
        }
        pair_other(view, point.coupling.x, solved.v, solved.other);
    } else {
        struct haptable_pair_view* told = (struct haptable_pair_view*)view; /* of a model, which is no constant */
        told->share = pair_solve(view, &point.own.own, point.coupling.x, &solved);
        if (view->share < 1.0f) pair_fade(view->share, &point.coupling);
        energy->energy_j = solved.energy_j;
        put_load(tables->law, point.own.own.a, solved.v, energy->load_n);
        if (terms == HAPTABLE_ENERGY_LOAD) return;
    }
    tables->bend->slope(tables->model, contact, &point.own, solved.v, &slope);
    for (b = 0; b < 2; ++b)
        energy->gradient_j[b] = slope.first_j[b] - pair_bilinear(point.coupling.first[b], solved.v, solved.other);
    if (terms == HAPTABLE_ENERGY_ALL) put_bend(view, &point, &solved, &slope, energy);
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
