/* SPDX-License-Identifier: MIT
 *
 * What contacts of two fingers made on a body that nothing holds, and nothing paid for (docs/design/moving.md): what
 * haptable_body_pair.c and haptable_body_modes_pair.c share.
 */
#ifndef HAPTABLE_BODY_DEBT_H
#define HAPTABLE_BODY_DEBT_H

#include "haptable_body.h"
#include "haptable_pair.h"
#include "haptable_vector.h"

static inline float body_motion_of(const struct haptable_body* body, const struct haptable_body_state* state) {
    float momentum[3];
    vec_symmetric_product(body->inertia_kg_m2, state->spin_rad_per_s, momentum);
    return 0.5f * (body->mass_kg * vec_dot(state->velocity_m_per_s, state->velocity_m_per_s) +
                   vec_dot(momentum, state->spin_rad_per_s));
}

/* Of what sampled contacts make, K/2 times a hand's way in a tick, squared, is the hand's own to damp: a device that
 * bears the stiffest contact does (docs/STABILITY.md). */
static inline float body_damped_by_hands(const struct haptable_model* model, const struct haptable_body_push push[]) {
    float speed2 = 0.0f;
    int i;
    for (i = 0; i < HAPTABLE_FINGERS; ++i) speed2 += vec_dot(push[i].velocity_m_per_s, push[i].velocity_m_per_s);
    return 0.5f * model->stiffness_limit_n_per_m * speed2 * (HAPTABLE_BODY_TICK_S * HAPTABLE_BODY_TICK_S);
}

/* made_j: by contacts since the last tick. Takes it out of the body's motion. Returns what is owed after it. */
static inline float body_settle_up(const struct haptable_model* model, const struct haptable_body* body,
                                   const struct haptable_body_push push[], float owed_j, float made_j,
                                   struct haptable_body_state* state) {
    const float motion_j = body_motion_of(body, state);
    const float paid_j = made_j > motion_j ? motion_j : made_j;
    owed_j = owed_j + (made_j > 0.0f ? made_j - paid_j : made_j) - body_damped_by_hands(model, push);
    haptable_body_brake(body, state, made_j);
    return owed_j > 0.0f ? owed_j : 0.0f;
}

static inline void body_scale_vector(float by, float v[3]) {
    v[0] *= by;
    v[1] *= by;
    v[2] *= by;
}

/* The forces of both, as much as has been paid for of what the contacts store, energy_j. */
static inline void body_scale_forces(float owed_j, float energy_j, struct haptable_body_state* state,
                                     struct haptable_pair* pair, struct haptable_body_push push[],
                                     struct haptable_output out[]) {
    const float share = owed_j < energy_j ? 1.0f - owed_j / energy_j : 0.0f;
    int i;
    int corner;
    if (!(owed_j > 0.0f)) return; /* most ticks */
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        body_scale_vector(share, push[i].force_n);
        push[i].stiffness_n_per_m *= share;
        body_scale_vector(share, state->given_n[i]);
        body_scale_vector(share, pair->servo[i].given_n);
        for (corner = 0; corner < 3; ++corner) body_scale_vector(share, out[i].nodal_force_n[corner]);
    }
}

#endif
