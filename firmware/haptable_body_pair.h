/* SPDX-License-Identifier: MIT
 *
 * Two fingers that feel one another's dents on a body that nothing holds: they push it, turn it, grasp and lift it.
 */
#ifndef HAPTABLE_BODY_PAIR_H
#define HAPTABLE_BODY_PAIR_H

#include "haptable_body.h"
#include "haptable_pair.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As haptable_body_step, with haptable_pair_step in the body's frame. Bounded work: that, then haptable_body_move. */
void haptable_body_pair_step(const struct haptable_pair_model* tables, const struct haptable_body* body,
                             struct haptable_body_state* state, struct haptable_pair* pair,
                             const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                             struct haptable_output out[HAPTABLE_FINGERS]);

/* The same up to the body's motion, which is to follow by haptable_body_move with push[]: what contacts have made was
 * taken back. */
void haptable_body_pair_feel(const struct haptable_pair_model* tables, const struct haptable_body* body,
                             struct haptable_body_state* state, struct haptable_pair* pair,
                             const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                             struct haptable_body_push push[HAPTABLE_FINGERS],
                             struct haptable_output out[HAPTABLE_FINGERS]);

/* The same of finger `number` alone, 0 or 1, while the other is away: as haptable_body_step of one finger. What the
 * body remembers of the other is forgotten. */
void haptable_body_step_finger(const struct haptable_model* model, const struct haptable_body* body,
                               struct haptable_body_state* state, struct haptable_servo* servo, int number,
                               const float finger_m[3], uint32_t now_us, struct haptable_output* out);

#ifdef __cplusplus
}
#endif

#endif
