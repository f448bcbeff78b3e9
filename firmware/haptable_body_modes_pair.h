/* SPDX-License-Identifier: MIT
 *
 * Two fingers on a body that nothing holds and that rings.
 */
#ifndef HAPTABLE_BODY_MODES_PAIR_H
#define HAPTABLE_BODY_MODES_PAIR_H

#include "haptable_body.h"
#include "haptable_modes_pair.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As haptable_body_pair_step, with haptable_modes_pair_feel in the body's frame. What contacts made is taken out of the
 * modes' motion, then out of the body's, and what is left is owed. Bounded work: that, then haptable_body_move. */
void haptable_body_modes_pair_step(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                   const struct haptable_body* body, struct haptable_body_state* state,
                                   struct haptable_modes_pair* swings, struct haptable_pair* pair,
                                   const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                                   struct haptable_output out[HAPTABLE_FINGERS]);

/* The same up to the body's motion, which is to follow by haptable_body_move with push[]. */
void haptable_body_modes_pair_feel(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                   const struct haptable_body* body, struct haptable_body_state* state,
                                   struct haptable_modes_pair* swings, struct haptable_pair* pair,
                                   const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                                   struct haptable_body_push push[HAPTABLE_FINGERS],
                                   struct haptable_output out[HAPTABLE_FINGERS]);

/* Of finger `number` alone, 0 or 1, while the other is away: as haptable_body_modes_step. What is known of the other is
 * forgotten. */
void haptable_body_modes_pair_step_finger(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                          const struct haptable_body* body, struct haptable_body_state* state,
                                          struct haptable_modes_pair* swings, struct haptable_pair* pair, int number,
                                          const float finger_m[3], uint32_t now_us, struct haptable_output* out);

#ifdef __cplusplus
}
#endif

#endif
