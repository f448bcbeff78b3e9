/* SPDX-License-Identifier: MIT
 *
 * [C_1 X; X^T C_2] f = u,   C_c = C(alpha) of one finger,   X = sum_kl w_k w_l C_kl over the controls of two patches
 */
#include "haptable_pair_terms.h"

static const struct haptable_compliance_form consistent_form = {2, {0, 3, 5}, {{4}, {2}, {1}}, {0}};
static const struct haptable_compliance_form mask_form = {
    4, {0, 10, 14}, {{11, 12, 13}, {9, 5, 2}, {1, 3, 6}}, {4, 7, 8}};

/* C(alpha) by its nets of degree 2 and 1, lifted where fixed vertices ask for it. A is not linear's sum for the lift
 * alone. */
static inline void open_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                           const struct haptable_contact* contact, const float finger_m[3],
                           struct haptable_pair_point* point) {
    const float fraction = fixed_fraction(model, contact);
    struct net net;
    gather(model, form, contact->patch, &net);
    if (form->degree == 4) {
        int corner = 0;
        const enum place_on_patch feature = feature_of(contact->alpha, &corner);
        quadratic_net(&net, contact->alpha, feature, corner, &point->net);
    } else {
        int n;
        for (n = 0; n < 6; ++n) point->net.block[n] = net.block[n];
    }
    linear_of(point->net.block, contact->alpha, point->linear);
    mix_three(contact->alpha, point->linear[0], point->linear[1], point->linear[2], point->own.a);
    point->lifted = point->steps = 0;
    if (fraction > 0.0f) {
        point->steps = (uint8_t)is_at_lift(model, contact->patch, fraction, form->degree, point->linear, point->own.a);
        point->lifted = (uint8_t)lift(model, fraction, point->own.a);
    }
    edges_of(model, contact->patch, point->e);
    vec_sub(finger_m, contact->god_object_m, point->u);
    vec_copy(point->u, point->own.s);
}

static inline void slope_of(const struct haptable_model* model, int degree, const struct haptable_contact* contact,
                            struct haptable_pair_point* point, const float v[3], struct haptable_pair_slope* slope) {
    const float by[3] = {v[0], v[1], v[2]}; /* apart from what is written */
    float first_m[2][3];
    float second_j[3];
    int b;
    vary(degree, point->linear, by, point->lifted, first_m);
    if (point->lifted) vary_fraction(model, contact->patch, by, first_m);
    bend_net(point->net.block, degree, by, point->lifted, second_j);
    for (b = 0; b < 2; ++b) {
        const float* e = point->e[b];
        const float* a_v = first_m[b];
        slope->first_j[b] = -vec_dot(e, by) - 0.5f * vec_dot(by, a_v);
        slope->y[b][0] = -e[0] - a_v[0];
        slope->y[b][1] = -e[1] - a_v[1];
        slope->y[b][2] = -e[2] - a_v[2];
        vec_copy(a_v, slope->a_v[b]);
    }
    for (b = 0; b < 3; ++b) slope->second_j[b] = -0.5f * second_j[b];
}

static void open_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                            const float finger_m[3], struct haptable_pair_point* point) {
    open_of(model, &consistent_form, contact, finger_m, point);
}

static void open_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                      const float finger_m[3], struct haptable_pair_point* point) {
    open_of(model, &mask_form, contact, finger_m, point);
}

static void slope_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                             struct haptable_pair_point* point, const float v[3], struct haptable_pair_slope* slope) {
    slope_of(model, 2, contact, point, v, slope);
}

static void slope_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                       struct haptable_pair_point* point, const float v[3], struct haptable_pair_slope* slope) {
    slope_of(model, 4, contact, point, v, slope);
}

const struct haptable_pair_bend haptable_pair_bend_consistent = {open_consistent, slope_consistent};
const struct haptable_pair_bend haptable_pair_bend_pressure_mask = {open_mask, slope_mask};

/* At once: half the work of the net. */
static void own_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                           const float finger_m[3], struct haptable_pair_own* terms) {
    struct net net;
    gather(model, &consistent_form, contact->patch, &net);
    quadratic_c(&net, contact->alpha, terms->a);
    lift(model, fixed_fraction(model, contact), terms->a);
    vec_sub(finger_m, contact->god_object_m, terms->s);
}

static void own_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                     const float finger_m[3], struct haptable_pair_own* terms) {
    struct net net;
    gather(model, &mask_form, contact->patch, &net);
    quartic_c(&net, contact->alpha, terms->a);
    lift(model, fixed_fraction(model, contact), terms->a);
    vec_sub(finger_m, contact->god_object_m, terms->s);
}

static void put_load(const struct haptable_model* model, const struct haptable_contact* contact, const float v[3],
                     float nodal_force_n[3][3], float force_n[3]) {
    (void)model;
    haptable_compliance_distribute(v, contact, nodal_force_n, force_n);
}

const struct haptable_pair_law haptable_pair_consistent = {3, 0, own_consistent, put_load};
const struct haptable_pair_law haptable_pair_pressure_mask = {HAPTABLE_PAIR_CONTROLS, 0, own_mask, put_load};
