/* SPDX-License-Identifier: MIT
 *
 * fingers -> body coordinates -> haptable_pair_step -> what they do to the body -> its motion
 */
#include "haptable_body_pair.h"

#include "haptable_vector.h"

/* ---- what contacts made and nothing paid for ------------------------------------------------------------------ */

/* A finger that begins to touch where the other has dented or raised the surface stores at once what it would have paid
 * on its way there: the energy of both steps up. What the body's motion does not pay of such a step is owed, and the
 * forces of both are scaled to what has been paid for: with F -> (1 - owed / E) F they store as much less.
 * state->stored_j: E of both, and less what is owed. */
static float owed_of(const struct haptable_body_state* state) {
    return state->stored_j[1] < 0.0f ? -state->stored_j[1] : 0.0f;
}

static float motion_of(const struct haptable_body* body, const struct haptable_body_state* state) {
    float momentum[3];
    vec_symmetric_product(body->inertia_kg_m2, state->spin_rad_per_s, momentum);
    return 0.5f * (body->mass_kg * vec_dot(state->velocity_m_per_s, state->velocity_m_per_s) +
                   vec_dot(momentum, state->spin_rad_per_s));
}

/* Of what sampled contacts make, K/2 times a hand's way in a tick, squared, is the hand's own to damp: a device that
 * bears the stiffest contact does (docs/STABILITY.md). */
static float damped_by_hands(const struct haptable_model* model, const struct haptable_body_push push[]) {
    float speed2 = 0.0f;
    int i;
    for (i = 0; i < HAPTABLE_FINGERS; ++i) speed2 += vec_dot(push[i].velocity_m_per_s, push[i].velocity_m_per_s);
    return 0.5f * model->stiffness_limit_n_per_m * speed2 * (HAPTABLE_BODY_TICK_S * HAPTABLE_BODY_TICK_S);
}

/* made_j: by contacts since the last tick. Takes it out of the body's motion; what is left goes to what is owed. */
static void settle_up(const struct haptable_model* model, const struct haptable_body* body,
                      const struct haptable_body_push push[], float energy_j, float made_j,
                      struct haptable_body_state* state) {
    const float motion_j = motion_of(body, state);
    const float paid_j = made_j > motion_j ? motion_j : made_j;
    const float owed_j = owed_of(state) + (made_j > 0.0f ? made_j - paid_j : made_j) - damped_by_hands(model, push);
    haptable_body_brake(body, state, made_j);
    state->stored_j[0] = energy_j;
    state->stored_j[1] = owed_j > 0.0f ? -owed_j : 0.0f;
}

static void scale_vector(float by, float v[3]) {
    v[0] *= by;
    v[1] *= by;
    v[2] *= by;
}

/* The forces of both, as much as has been paid for. */
static void scale_forces(struct haptable_body_state* state, struct haptable_pair* pair,
                         struct haptable_body_push push[], struct haptable_output out[]) {
    const float owed_j = owed_of(state);
    const float share = owed_j < state->stored_j[0] ? 1.0f - owed_j / state->stored_j[0] : 0.0f;
    int i;
    int corner;
    if (!(owed_j > 0.0f)) return; /* most ticks */
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        scale_vector(share, push[i].force_n);
        push[i].stiffness_n_per_m *= share;
        scale_vector(share, state->given_n[i]);
        scale_vector(share, pair->servo[i].given_n);
        for (corner = 0; corner < 3; ++corner) scale_vector(share, out[i].nodal_force_n[corner]);
    }
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
    state->stored_j[1] = -owed_j;
    settle_up(tables->model, body, push, pair->energy_j, made_j + pair->energy_j, state);
    scale_forces(state, pair, push, out);
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
