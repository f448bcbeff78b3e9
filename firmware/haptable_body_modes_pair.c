/* SPDX-License-Identifier: MIT
 *
 * fingers -> body coordinates -> haptable_modes_pair_feel -> what they do to the body -> its motion
 */
#include "haptable_body_modes_pair.h"

#include "haptable_body_debt.h"
#include "haptable_vector.h"

/* What finger `number` does to the body, its dent being that against the surface as the modes have moved it. Returns
 * what its force gave to hand and body since the last tick, J: what is stored is in swings. */
static float push_of(const struct haptable_model* model, const struct haptable_body* body,
                     const struct haptable_servo* servo, struct haptable_body_state* state, int number,
                     const float world_m[3], const float at_m[3], const struct haptable_output* out,
                     struct haptable_body_push* push) {
    float given_j;
    state->stored_j[number] = 0.0f;
    given_j = haptable_body_push_of(model, body, servo, state, number, world_m,
                                    servo->finger_known ? servo->finger_m : at_m, out, push);
    if (servo->finger_known) vec_copy(at_m, push->at_m);
    given_j -= state->stored_j[number];
    state->stored_j[number] = 0.0f;
    return given_j;
}

void haptable_body_modes_pair_feel(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                   const struct haptable_body* body, struct haptable_body_state* state,
                                   struct haptable_modes_pair* swings, struct haptable_pair* pair,
                                   const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                                   struct haptable_body_push push[HAPTABLE_FINGERS],
                                   struct haptable_output out[HAPTABLE_FINGERS]) {
    const float before_j = swings->stored_j;
    float at_m[HAPTABLE_FINGERS][3];
    float made_j;
    int i;
    for (i = 0; i < HAPTABLE_FINGERS; ++i) haptable_body_from_world(body, state, finger_m[i], at_m[i]);
    (void)haptable_modes_pair_feel(modes, tables, swings, pair, (const float(*)[3])at_m, now_us, out);
    made_j = swings->stored_j - before_j;
    for (i = 0; i < HAPTABLE_FINGERS; ++i)
        made_j += push_of(tables->model, body, &pair->servo[i], state, i, finger_m[i], at_m[i], &out[i], &push[i]);
    swings->owed_j = body_settle_up(tables->model, body, push, swings->owed_j, made_j, state);
    body_scale_forces(swings->owed_j, swings->contact_j, state, pair, push, out);
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        vec_copy(push[i].force_n, swings->met[i].load_n);
        vec_copy(state->given_n[i], out[i].force_n);
    }
}

void haptable_body_modes_pair_step(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                   const struct haptable_body* body, struct haptable_body_state* state,
                                   struct haptable_modes_pair* swings, struct haptable_pair* pair,
                                   const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                                   struct haptable_output out[HAPTABLE_FINGERS]) {
    struct haptable_body_push push[HAPTABLE_FINGERS];
    haptable_body_modes_pair_feel(modes, tables, body, state, swings, pair, finger_m, now_us, push, out);
    haptable_body_move(body, state, push, HAPTABLE_FINGERS);
}

void haptable_body_modes_pair_step_finger(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                          const struct haptable_body* body, struct haptable_body_state* state,
                                          struct haptable_modes_pair* swings, struct haptable_pair* pair, int number,
                                          const float finger_m[3], uint32_t now_us, struct haptable_output* out) {
    const float before_j = (swings->stored_j - swings->owed_j) - state->stored_j[number];
    const int other = 1 - number;
    struct haptable_servo* servo = &pair->servo[number];
    struct haptable_body_push push;
    float at_m[3];
    float made_j;
    state->finger_known[other] = 0;
    vec_zero(state->given_n[other]);
    state->stored_j[other] = state->worked_j[other] = 0.0f;
    haptable_body_from_world(body, state, finger_m, at_m);
    haptable_modes_pair_step_finger(modes, tables, swings, pair, number, at_m, now_us, out);
    made_j = haptable_body_push_of(tables->model, body, servo, state, number, finger_m,
                                   servo->finger_known ? servo->finger_m : at_m, out, &push);
    if (servo->finger_known) vec_copy(at_m, push.at_m);
    made_j += (swings->stored_j - state->stored_j[number]) - before_j;
    vec_copy(state->given_n[number], out->force_n);
    haptable_body_brake(body, state, made_j);
    haptable_body_move(body, state, &push, 1);
    if (number == 0) return;
    state->worked_j[number] = state->worked_j[0]; /* of the one push */
    state->worked_j[0] = 0.0f;
}
