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
    haptable_pair_step(tables, pair, at_m[0], at_m[1], now_us, out);
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        made_j += haptable_body_push_of(tables->model, body, &pair->servo[i], state, i, finger_m[i], at_m[i], &out[i],
                                        &push[i]);
        vec_copy(state->given_n[i], out[i].force_n);
    }
    haptable_body_brake(body, state, made_j);
    haptable_body_move(body, state, push, HAPTABLE_FINGERS);
}

static void forget(struct haptable_body_state* state, int number) {
    state->finger_known[number] = 0;
    vec_zero(state->given_n[number]);
    state->stored_j[number] = state->worked_j[number] = 0.0f;
}

static void put_no_push(const struct haptable_body* body, struct haptable_body_push* push) {
    vec_copy(body->centre_m, push->at_m);
    vec_zero(push->force_n);
    vec_zero(push->velocity_m_per_s);
    push->stiffness_n_per_m = 0.0f;
    push->sticks = 0;
}

void haptable_body_step_finger(const struct haptable_model* model, const struct haptable_body* body,
                               struct haptable_body_state* state, struct haptable_servo* servo, int number,
                               const float finger_m[3], uint32_t now_us, struct haptable_output* out) {
    struct haptable_body_push push[HAPTABLE_FINGERS];
    float at_m[3];
    float made_j;
    forget(state, 1 - number);
    put_no_push(body, &push[0]);
    haptable_body_from_world(body, state, finger_m, at_m);
    haptable_step(model, servo, at_m, now_us, out);
    made_j = haptable_body_push_of(model, body, servo, state, number, finger_m, at_m, out, &push[number]);
    vec_copy(state->given_n[number], out->force_n);
    haptable_body_brake(body, state, made_j);
    haptable_body_move(body, state, push, number + 1);
}
