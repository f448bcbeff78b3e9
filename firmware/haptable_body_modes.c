/* SPDX-License-Identifier: MIT
 *
 * finger -> body coordinates -> haptable_modes_step -> what it does to the body -> its motion
 */
#include "haptable_body_modes.h"

#include "haptable_vector.h"

void haptable_body_modes_step(const struct haptable_modes* modes, const struct haptable_body* body,
                              struct haptable_body_state* state, struct haptable_modes_state* swings,
                              struct haptable_servo* servo, const float finger_m[3], uint32_t now_us,
                              struct haptable_output* out) {
    const float before_j = swings->stored_j - state->stored_j[0];
    struct haptable_body_push push;
    float at_m[3];
    float made_j;
    haptable_body_from_world(body, state, finger_m, at_m);
    haptable_modes_step(modes, swings, servo, at_m, now_us, out);
    /* The contact's dent is that of the finger against the surface as the modes have moved it. */
    made_j = haptable_body_push_of(modes->model, body, servo, state, 0, finger_m,
                                   servo->finger_known ? servo->finger_m : at_m, out, &push);
    if (servo->finger_known) vec_copy(at_m, push.at_m);
    made_j += (swings->stored_j - state->stored_j[0]) - before_j; /* in the modes, and set apart for the shift */
    vec_copy(state->given_n[0], out->force_n);
    haptable_body_brake(body, state, made_j);
    haptable_body_move(body, state, &push, 1);
}
