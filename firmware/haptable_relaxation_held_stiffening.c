/* SPDX-License-Identifier: MIT
 *
 * The relaxation of a body whose dents stiffen, and that friction or a hand may hold
 */
#include "haptable_relaxation_held.h"
#include "haptable_stiffening.h"

void haptable_relaxation_held_stiffened(const struct haptable_model* model, struct haptable_servo* servo, float factor,
                                        struct haptable_output* out) {
    relaxation_held(model, servo, 1, factor, out);
}

void haptable_relaxation_held_stiffening(const struct haptable_model* model, struct haptable_servo* servo,
                                         struct haptable_output* out) {
    const float factor = stiffening_factor_of(model, servo, out);
    vec_scale(factor, out->force_n);
    haptable_relaxation_held_stiffened(model, servo, factor, out);
}
