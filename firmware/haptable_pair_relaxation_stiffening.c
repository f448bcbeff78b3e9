/* SPDX-License-Identifier: MIT
 *
 * The relaxation of a body whose dents stiffen under two fingers, or one of them alone
 */
#include "haptable_relaxation.h"

void haptable_pair_relaxation_stiffening(const struct haptable_model* model, struct haptable_servo* servo,
                                         struct haptable_output* out) {
    struct haptable_stiffened unused;
    const int touches = out->patch != HAPTABLE_NONE;
    const float factor = touches ? model->stiffen(model, servo, &unused) : 1.0f;
    if (model->stiffen == haptable_stiffened_of) vec_scale(factor, out->force_n); /* alone the force is linear yet */
    haptable_relaxation_held_stiffened(model, servo, factor, out);
}
