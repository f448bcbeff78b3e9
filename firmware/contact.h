/* SPDX-License-Identifier: MIT
 *
 * The god-object of Zilles and Salisbury (1995) on a closed triangle surface. A pure function of the tables, the
 * previous contact and the finger's way: no state of its own, no drawing, no input or output.
 */
#ifndef HAPTABLE_CONTACT_H
#define HAPTABLE_CONTACT_H

#include "haptable.h"

/* Moves the god-object of one tick.
 *
 * In contact it slides on the surface towards the finger and lets go when the finger is outside; from there, or from
 * `from_m` when there was no contact, the way to `to_m` is searched for the first patch that it crosses inwards, where
 * contact begins.
 *
 * before: contact->patch is HAPTABLE_NONE, or contact holds a point of the surface; positions are finite and within
 *         reach_m of the body.
 * after:  contact->patch is HAPTABLE_NONE and the finger is outside, or 0 <= alpha <= 1, sum 1, god_object =
 *         sum alpha V, and no neighbouring patch is nearer to the finger (unless a limit was met: counted).
 * cost:   slides: at most HAPTABLE_WALK_STEPS steps and 13 to finish the last look, each at most 65 instructions of a
 *         Cortex-M or rv32imafc; queries: at most HAPTABLE_SLIDES, each at most 280 instructions a box that it visits;
 *         with checks and force, 2,200 for the rest. tests/firmware/target_test.cpp holds every tick to this. */
void contact_move(const struct haptable_model* model, struct haptable_contact* contact, const float from_m[3],
                  const float to_m[3], struct haptable_counters* counters);

/* The area coordinates (eq. 11) and the position of the point of a patch that is nearest to x.
 * after: 0 <= alpha <= 1, sum 1 to rounding; alpha is exactly 0 at the corners opposite to the edges it lies on. */
void contact_nearest(const struct haptable_model* model, uint16_t patch, const float x_m[3],
                     struct haptable_contact* nearest);

#endif
