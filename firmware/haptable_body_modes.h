/* SPDX-License-Identifier: MIT
 *
 * A body that nothing holds and that rings.
 */
#ifndef HAPTABLE_BODY_MODES_H
#define HAPTABLE_BODY_MODES_H

#include "haptable_body.h"
#include "haptable_modes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As haptable_body_step with one finger, whose step is haptable_modes_step. Bounded work: that, then
 * haptable_body_move. */
void haptable_body_modes_step(const struct haptable_modes* modes, const struct haptable_body* body,
                              struct haptable_body_state* state, struct haptable_modes_state* swings,
                              struct haptable_servo* servo, const float finger_m[3], uint32_t now_us,
                              struct haptable_output* out);

#ifdef __cplusplus
}
#endif

#endif
