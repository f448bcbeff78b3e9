/* SPDX-License-Identifier: MIT
 *
 * F = F_e t / s,   s = Psi' sqrt(u . S u):   the elastic force of a dent that stiffens relaxes (Fung 1981)
 *
 * A linear body of the force Psi' F_e has this s, as u . Psi' F_e = s^2; of its relaxed force 1 / Psi' is felt.
 */
#include "haptable_relaxation.h"
#include "haptable_stiffening.h"

void haptable_relaxation_slide_stiffened(const struct haptable_model* model, const struct haptable_servo* servo,
                                         struct haptable_relaxed* relaxed, float factor, struct haptable_output* out) {
    vec_scale(factor, out->force_n);
    haptable_relaxation_slide(model, servo, relaxed, out);
    vec_scale(1.0f / factor, out->force_n);
}

void haptable_relaxation_stiffening(const struct haptable_model* model, struct haptable_servo* servo,
                                    struct haptable_output* out) {
    const float factor = stiffening_factor_of(model, servo, out);
    vec_scale(factor, out->force_n);
    haptable_relaxation_slide_stiffened(model, servo, haptable_relaxation_meet(model, servo), factor, out);
}
