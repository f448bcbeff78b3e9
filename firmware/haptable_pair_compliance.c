/* SPDX-License-Identifier: MIT
 *
 * [C_1 X; X^T C_2] f = u,   C_c = C(alpha) of one finger,   X = sum_kl w_k w_l C_kl over the controls of two patches
 */
#include "haptable_pair_terms.h"

static const struct haptable_compliance_form consistent_form = {2, {0, 3, 5}, {{4}, {2}, {1}}, {0}};
static const struct haptable_compliance_form mask_form = {
    4, {0, 10, 14}, {{11, 12, 13}, {9, 5, 2}, {1, 3, 6}}, {4, 7, 8}};

/* C(alpha) by the net of degree 1, lifted where fixed vertices ask for it. */
struct own {
    struct net net;
    float linear[3][6];
    int lifted;
    int steps; /* the load's slope does */
    struct haptable_pair_own terms;
};

static inline void own_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                          const struct haptable_contact* contact, const float finger_m[3], struct own* own) {
    const float fraction = fixed_fraction(model, contact);
    gather(model, form, contact->patch, &own->net);
    linear_net(&own->net, form->degree, contact->alpha, own->linear);
    evaluate_c(own->linear, contact->alpha, own->terms.a);
    own->steps =
        fraction > 0.0f && is_at_lift(model, contact->patch, fraction, form->degree, own->linear, own->terms.a);
    own->lifted = lift(model, fraction, own->terms.a);
    vec_sub(finger_m, contact->god_object_m, own->terms.s);
}

/* Without the net: half the work. */
static void own_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                           const float finger_m[3], struct haptable_pair_own* terms) {
    const struct haptable_compliance* table = model->compliance;
    const uint16_t* v = model->patch[contact->patch];
    const uint16_t* e = table->patch_edge[contact->patch];
    const float* a = contact->alpha;
    int c;
    set_block(a[0] * a[0], table->vertex[v[0]], terms->a);
    add_block(a[1] * a[1], table->vertex[v[1]], terms->a);
    add_block(a[2] * a[2], table->vertex[v[2]], terms->a);
    for (c = 0; c < 3; ++c) add_block(2.0f * a[next_corner(c)] * a[previous_corner(c)], table->edge[e[c]], terms->a);
    lift(model, fixed_fraction(model, contact), terms->a);
    vec_sub(finger_m, contact->god_object_m, terms->s);
}

static void own_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                     const float finger_m[3], struct haptable_pair_own* terms) {
    struct own own;
    own_of(model, &mask_form, contact, finger_m, &own);
    *terms = own.terms;
}

static void put_load(const struct haptable_model* model, const struct haptable_contact* contact, const float v[3],
                     float nodal_force_n[3][3], float force_n[3]) {
    (void)model;
    haptable_compliance_distribute(v, contact, nodal_force_n, force_n);
}

const struct haptable_pair_law haptable_pair_consistent = {3, 0, own_consistent, put_load};
const struct haptable_pair_law haptable_pair_pressure_mask = {HAPTABLE_PAIR_CONTROLS, 0, own_mask, put_load};

/* What an evaluation has before the load is known. */
struct point {
    struct own own;
    struct pair_coupling coupling;
    float e[2][3];
};

static void begin_point(const struct haptable_model* model, const struct haptable_compliance_form* form,
                        const struct haptable_contact* contact, const float finger_m[3], struct point* point) {
    float normal[3];
    patch_frame(model, contact->patch, point->e[0], point->e[1], normal);
    own_of(model, form, contact, finger_m, &point->own);
    pair_couple(pair_view_of(model), contact, point->e, &point->coupling);
}

/* The gradient for both fingers' loads, and y: s_b - C_b f. */
static void put_slope(const struct haptable_model* model, const struct haptable_compliance_form* form, uint16_t patch,
                      struct point* point, const float load_n[3], const float other_n[3], float y[2][3],
                      struct haptable_energy* energy) {
    int b;
    vary(form->degree, point->own.linear, load_n, point->own.lifted, y);
    if (point->own.lifted) vary_fraction(model, patch, load_n, y);
    for (b = 0; b < 2; ++b) {
        const float* e = point->e[b];
        energy->gradient_j[b] = -vec_dot(e, load_n) - 0.5f * vec_dot(load_n, y[b]) -
                                pair_bilinear(point->coupling.first[b], load_n, other_n);
        y[b][0] = -e[0] - y[b][0];
        y[b][1] = -e[1] - y[b][1];
        y[b][2] = -e[2] - y[b][2];
    }
}

static void put_gradient(const struct haptable_model* model, const struct haptable_compliance_form* form,
                         const struct haptable_contact* contact, const float finger_m[3],
                         struct haptable_energy* energy) {
    struct point point;
    float other[3];
    float y[2][3];
    begin_point(model, form, contact, finger_m, &point);
    pair_other(pair_view_of(model), point.coupling.x, energy->load_n, other);
    put_slope(model, form, contact->patch, &point, energy->load_n, other, y, energy);
}

static void put_energy(const struct haptable_model* model, const struct haptable_compliance_form* form,
                       const struct haptable_contact* contact, const float finger_m[3],
                       struct haptable_energy* energy) {
    const struct haptable_pair_view* view = pair_view_of(model);
    struct point point;
    struct pair_solved solved;
    float y[2][3];
    int b;
    begin_point(model, form, contact, finger_m, &point);
    pair_solve(view, &point.own.terms, point.coupling.x, &solved);
    vec_copy(solved.v, energy->load_n);
    energy->energy_j = solved.energy_j;
    put_slope(model, form, contact->patch, &point, solved.v, solved.other, y, energy);
    vary_twice(&point.own.net, form->degree, contact->alpha, solved.v, point.own.lifted, energy->hessian_j);
    for (b = 0; b < 3; ++b) energy->hessian_j[b] *= -0.5f;
    pair_bend(view, &point.coupling, &solved, y, energy);
    for (b = 0; b < 2; ++b) vec_copy(y[b], energy->load_gradient_n[b]);
    if (point.own.steps) forget_slope(energy);
}

static void put_terms(const struct haptable_model* model, const struct haptable_compliance_form* form,
                      const struct haptable_contact* contact, const float finger_m[3], enum haptable_energy_terms terms,
                      struct haptable_energy* energy) {
    if (terms != HAPTABLE_ENERGY_GRADIENT)
        put_energy(model, form, contact, finger_m, energy);
    else
        put_gradient(model, form, contact, finger_m, energy);
}

void haptable_pair_energy_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                                     const float finger_m[3], enum haptable_energy_terms terms,
                                     struct haptable_energy* energy) {
    if (pair_view_of(model)->is_coupled)
        put_terms(model, &consistent_form, contact, finger_m, terms, energy);
    else
        haptable_energy_consistent(model, contact, finger_m, terms, energy);
}

void haptable_pair_energy_pressure_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                                        const float finger_m[3], enum haptable_energy_terms terms,
                                        struct haptable_energy* energy) {
    if (pair_view_of(model)->is_coupled)
        put_terms(model, &mask_form, contact, finger_m, terms, energy);
    else
        haptable_energy_pressure_mask(model, contact, finger_m, terms, energy);
}
