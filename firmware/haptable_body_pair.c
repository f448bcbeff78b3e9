/* SPDX-License-Identifier: MIT
 *
 * fingers -> body coordinates -> haptable_pair_step -> what they do to the body -> its motion
 */
#include "haptable_body_pair.h"

#include "haptable_body_debt.h"
#include "haptable_vector.h"

/* ---- what contacts made and nothing paid for ------------------------------------------------------------------ */

/* A finger that begins to touch where the other has dented or raised the surface stores at once what it would have paid
 * on its way there: the energy of both steps up. What the body's motion does not pay of such a step is owed, and the
 * forces of both are scaled to what has been paid for: with F -> (1 - owed / E) F they store as much less.
 * state->stored_j: E of both, and less what is owed. */
static float owed_of(const struct haptable_body_state* state) {
    return state->stored_j[1] < 0.0f ? -state->stored_j[1] : 0.0f;
}

void haptable_body_pair_feel(const struct haptable_pair_model* tables, const struct haptable_body* body,
                             struct haptable_body_state* state, struct haptable_pair* pair,
                             const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                             struct haptable_body_push push[HAPTABLE_FINGERS],
                             struct haptable_output out[HAPTABLE_FINGERS]) {
    const float owed_j = owed_of(state);
    float at_m[HAPTABLE_FINGERS][3];
    float made_j = -owed_j; /* that stays owed */
    int i;
    for (i = 0; i < HAPTABLE_FINGERS; ++i) haptable_body_from_world(body, state, finger_m[i], at_m[i]);
    haptable_pair_step(tables, pair, at_m[0], at_m[1], now_us, out);
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        made_j += haptable_body_push_of(tables->model, body, &pair->servo[i], state, i, finger_m[i], at_m[i], &out[i],
                                        &push[i]);
        made_j -= state->stored_j[i]; /* as if it were alone: energy_j is of both */
    }
    state->stored_j[0] = pair->energy_j;
    state->stored_j[1] = -body_settle_up(tables->model, body, push, owed_j, made_j + pair->energy_j, state);
    body_scale_forces(owed_of(state), pair->energy_j, state, pair, push, out);
    for (i = 0; i < HAPTABLE_FINGERS; ++i) vec_copy(state->given_n[i], out[i].force_n);
}

void haptable_body_pair_step(const struct haptable_pair_model* tables, const struct haptable_body* body,
                             struct haptable_body_state* state, struct haptable_pair* pair,
                             const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                             struct haptable_output out[HAPTABLE_FINGERS]) {
    struct haptable_body_push push[HAPTABLE_FINGERS];
    haptable_body_pair_feel(tables, body, state, pair, finger_m, now_us, push, out);
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
    state->stored_j[number] += state->stored_j[1 - number]; /* of both */
    forget(state, 1 - number);
    put_no_push(body, &push[0]);
    haptable_body_from_world(body, state, finger_m, at_m);
    haptable_step(model, servo, at_m, now_us, out);
    made_j = haptable_body_push_of(model, body, servo, state, number, finger_m, at_m, out, &push[number]);
    vec_copy(state->given_n[number], out->force_n);
    haptable_body_brake(body, state, made_j);
    haptable_body_move(body, state, push, number + 1);
}
