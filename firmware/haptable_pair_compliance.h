/* SPDX-License-Identifier: MIT
 *
 * C(alpha) of one of two fingers, whether its blocks stand in flash or are expanded: what haptable_pair_compliance.c
 * and haptable_pair_compliance_packed.c are made of.
 */
#ifndef HAPTABLE_PAIR_COMPLIANCE_H
#define HAPTABLE_PAIR_COMPLIANCE_H

#include "haptable_pair_terms.h"

/* The laws' slopes, which read the blocks of the place alone. */
haptable_pair_slope_fn haptable_pair_slope_consistent;
haptable_pair_slope_fn haptable_pair_slope_mask;
haptable_pair_load_fn haptable_pair_load_of_compliance;

static const struct haptable_compliance_form consistent_form = {2, {0, 3, 5}, {{4}, {2}, {1}}, {0}};
static const struct haptable_compliance_form mask_form = {
    4, {0, 10, 14}, {{11, 12, 13}, {9, 5, 2}, {1, 3, 6}}, {4, 7, 8}};

/* The net of degree 2 of the point: that of the patch, or at alpha of its net of degree 4. */
static inline void open_net(const struct net* net, int degree, const float alpha[3], struct reduced* quadratic) {
    if (degree == 4) {
        int corner = 0;
        const enum place_on_patch feature = feature_of(alpha, &corner);
        quadratic_net(net, alpha, feature, corner, quadratic);
    } else {
        int n;
        for (n = 0; n < 6; ++n) quadratic->block[n] = net->block[n];
    }
}

/* The rest of a place by its net of degree 1, lifted where fixed vertices ask for it. A is not linear's sum for the
 * lift alone. before: point->net. */
static inline void open_place(const struct haptable_model* model, int degree, const struct haptable_contact* contact,
                              const float finger_m[3], struct haptable_pair_point* point) {
    const float fraction = fixed_fraction(model, contact);
    linear_of(point->net.block, contact->alpha, point->linear);
    mix_three(contact->alpha, point->linear[0], point->linear[1], point->linear[2], point->own.a);
    point->lifted = point->steps = 0;
    if (fraction > 0.0f) {
        point->steps = (uint8_t)is_at_lift(model, contact->patch, fraction, degree, point->linear, point->own.a);
        point->lifted = (uint8_t)lift(model, fraction, point->own.a);
    }
    edges_of(model, contact->patch, point->e);
    vec_sub(finger_m, contact->god_object_m, point->u);
    vec_copy(point->u, point->own.s);
}

/* C at once: half the work of the net. */
static inline void own_place(const struct haptable_model* model, const struct net* net, int degree,
                             const struct haptable_contact* contact, const float finger_m[3],
                             struct haptable_pair_own* own) {
    if (degree == 4)
        quartic_c(net, contact->alpha, own->a);
    else
        quadratic_c(net, contact->alpha, own->a);
    lift(model, fixed_fraction(model, contact), own->a);
    vec_sub(finger_m, contact->god_object_m, own->s);
}

#endif
