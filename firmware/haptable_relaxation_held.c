/* SPDX-License-Identifier: MIT
 *
 * The relaxation of a linear body that friction or a hand may hold
 */
#include "haptable_relaxation_held.h"

void haptable_relaxation_held(const struct haptable_model* model, struct haptable_servo* servo,
                              struct haptable_output* out) {
    relaxation_held(model, servo, 0, 1.0f, out);
}
