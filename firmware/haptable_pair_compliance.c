/* SPDX-License-Identifier: MIT
 *
 * [C_1 X; X^T C_2] f = u,   C_c = C(alpha) of one finger,   X = sum_kl w_k w_l C_kl over the controls of two patches
 */
#include "haptable_pair_terms.h"

static const struct haptable_compliance_form consistent_form = {2, {0, 3, 5}, {{4}, {2}, {1}}, {0}};
static const struct haptable_compliance_form mask_form = {
    4, {0, 10, 14}, {{11, 12, 13}, {9, 5, 2}, {1, 3, 6}}, {4, 7, 8}};

/* C(alpha) by the net of degree 1, lifted where fixed vertices ask for it. A is not linear's sum for the lift alone. */
static inline void open_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                           const struct haptable_contact* contact, const float finger_m[3],
                           struct haptable_pair_point* point) {
    const float fraction = fixed_fraction(model, contact);
    struct net net;
    gather(model, form, contact->patch, &net);
    if (form->degree == 4)
        linear_of_four(&net, contact->alpha, point->linear);
    else
        linear_of(net.block, contact->alpha, point->linear);
    evaluate_c(point->linear, contact->alpha, point->own.a);
    point->steps =
        fraction > 0.0f && is_at_lift(model, contact->patch, fraction, form->degree, point->linear, point->own.a);
    point->lifted = (uint8_t)lift(model, fraction, point->own.a);
    vec_sub(finger_m, contact->god_object_m, point->own.s);
}

static inline void slope_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                            const struct haptable_contact* contact, struct haptable_pair_point* point, const float v[3],
                            struct haptable_pair_slope* slope) {
    struct net net;
    float e[2][3];
    float normal[3];
    int b;
    gather(model, form, contact->patch, &net);
    patch_frame(model, contact->patch, e[0], e[1], normal);
    vary(form->degree, point->linear, v, point->lifted, slope->y);
    if (point->lifted) vary_fraction(model, contact->patch, v, slope->y);
    for (b = 0; b < 2; ++b) {
        vec_copy(slope->y[b], slope->a_v[b]);
        slope->first_j[b] = -vec_dot(e[b], v) - 0.5f * vec_dot(v, slope->y[b]);
        slope->y[b][0] = -e[b][0] - slope->y[b][0];
        slope->y[b][1] = -e[b][1] - slope->y[b][1];
        slope->y[b][2] = -e[b][2] - slope->y[b][2];
    }
    vary_twice(&net, form->degree, contact->alpha, v, point->lifted, slope->second_j);
    for (b = 0; b < 3; ++b) slope->second_j[b] *= -0.5f;
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
                             const float finger_m[3], struct haptable_pair_point* point, const float v[3],
                             struct haptable_pair_slope* slope) {
    (void)finger_m;
    slope_of(model, &consistent_form, contact, point, v, slope);
}

static void slope_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                       const float finger_m[3], struct haptable_pair_point* point, const float v[3],
                       struct haptable_pair_slope* slope) {
    (void)finger_m;
    slope_of(model, &mask_form, contact, point, v, slope);
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
