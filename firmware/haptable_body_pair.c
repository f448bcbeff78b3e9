/* SPDX-License-Identifier: MIT
 *
 * fingers -> body coordinates -> haptable_pair_step -> what they do to the body -> its motion
 */
#include "haptable_body_pair.h"

#include "haptable_vector.h"

void haptable_body_pair_step(const struct haptable_pair_model* tables, const struct haptable_body* body,
                             struct haptable_body_state* state, struct haptable_pair* pair,
                             const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                             struct haptable_output out[HAPTABLE_FINGERS]) {
    struct haptable_body_push push[HAPTABLE_FINGERS];
    float at_m[HAPTABLE_FINGERS][3];
    float made_j = 0.0f;
    int i;
    for (i = 0; i < HAPTABLE_FINGERS; ++i) haptable_body_from_world(body, state, finger_m[i], at_m[i]);
    haptable_pair_step(tables, pair, (const float(*)[3])at_m, now_us, out);
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        made_j += haptable_body_push_of(tables->model, body, &pair->servo[i], state, i, finger_m[i], at_m[i], &out[i],
                                        &push[i]);
        vec_copy(state->given_n[i], out[i].force_n);
    }
    haptable_body_brake(body, state, made_j);
    haptable_body_move(body, state, push, HAPTABLE_FINGERS);
}
