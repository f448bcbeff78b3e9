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

static void own_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                           const float finger_m[3], struct haptable_pair_own* terms) {
    struct own own;
    own_of(model, &consistent_form, contact, finger_m, &own);
    *terms = own.terms;
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

/* The other's v where this one's load is known. */
static void take_load(const struct haptable_pair_view* view, const float x[9], const float load_n[3],
                      struct pair_solved* solved) {
    vec_copy(load_n, solved->v);
    pair_other(view, x, load_n, solved->other);
}

static void put_energy(const struct haptable_model* model, const struct haptable_compliance_form* form,
                       const struct haptable_contact* contact, const float finger_m[3],
                       enum haptable_energy_terms terms, struct haptable_energy* energy) {
    const struct haptable_pair_view* view = pair_view_of(model);
    const int whole = terms == HAPTABLE_ENERGY_ALL;
    struct own own;
    struct pair_coupling coupling;
    struct pair_solved solved;
    float e[2][3];
    float y[2][3];
    float normal[3];
    int b;
    patch_frame(model, contact->patch, e[0], e[1], normal);
    own_of(model, form, contact, finger_m, &own);
    pair_couple(view, contact, e, &coupling);
    if (whole) {
        pair_solve(view, &own.terms, coupling.x, &solved);
        vec_copy(solved.v, energy->load_n);
        energy->energy_j = solved.energy_j;
    } else {
        take_load(view, coupling.x, energy->load_n, &solved);
    }
    vary(form->degree, own.linear, solved.v, own.lifted, y);
    if (own.lifted) vary_fraction(model, contact->patch, solved.v, y);
    for (b = 0; b < 2; ++b) {
        energy->gradient_j[b] = -vec_dot(e[b], solved.v) - 0.5f * vec_dot(solved.v, y[b]) -
                                pair_bilinear(coupling.first[b], solved.v, solved.other);
        y[b][0] = -e[b][0] - y[b][0]; /* s_b - C_b f */
        y[b][1] = -e[b][1] - y[b][1];
        y[b][2] = -e[b][2] - y[b][2];
    }
    if (!whole) return;
    vary_twice(&own.net, form->degree, contact->alpha, solved.v, own.lifted, energy->hessian_j);
    for (b = 0; b < 3; ++b) energy->hessian_j[b] *= -0.5f;
    pair_bend(view, &coupling, &solved, y, energy);
    for (b = 0; b < 2; ++b) vec_copy(y[b], energy->load_gradient_n[b]);
    if (own.steps) forget_slope(energy);
}

void haptable_pair_energy_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                                     const float finger_m[3], enum haptable_energy_terms terms,
                                     struct haptable_energy* energy) {
    if (pair_view_of(model)->is_coupled)
        put_energy(model, &consistent_form, contact, finger_m, terms, energy);
    else
        haptable_energy_consistent(model, contact, finger_m, terms, energy);
}

void haptable_pair_energy_pressure_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                                        const float finger_m[3], enum haptable_energy_terms terms,
                                        struct haptable_energy* energy) {
    if (pair_view_of(model)->is_coupled)
        put_energy(model, &mask_form, contact, finger_m, terms, energy);
    else
        haptable_energy_pressure_mask(model, contact, finger_m, terms, energy);
}
