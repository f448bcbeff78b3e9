/* SPDX-License-Identifier: MIT
 *
 * Where the segment that a finger moved along first enters the surface.
 */
#ifndef HAPTABLE_ENTRY_H
#define HAPTABLE_ENTRY_H

#include "haptable.h"

/* A segment that is still to be searched; from_m may be segment->to_m. One from a finger (left: HAPTABLE_NONE) may
 * begin within tolerance_m behind a patch: it let go there a tick ago. One from a god-object that has let go of the
 * patch `left` begins on the patches around it, and they are behind it: only others count, farther than the tolerance
 * in front of it, or patches that touch it without being reached around a vertex (the other wedge of an edge where four
 * patches meet). */
void haptable_segment_begin(const float from_m[3], const float to_m[3], uint16_t left,
                            struct haptable_segment* segment);

/* Begins contact where the finger, now at x_m, first crossed the surface inwards: the first patch that its segment
 * enters, by the spatial index. First the segment that is not finished, if there is one, then from its end to x_m.
 * Returns 0, and leaves the contact, when it enters none as far as the tick's boxes go. after: contact, or the segment
 * up to x_m is searched, or segment->unfinished and box_limits counted. cost: at most HAPTABLE_TICK_BOXES boxes for all
 * calls of one tick. */
int haptable_surface_enter(const struct haptable_model* model, const float x_m[3], struct haptable_segment* segment,
                           struct haptable_contact* contact, struct haptable_counters* counters);

/* The finger has left the surface at the contact: the segment from there to x_m is to be searched, as it may enter
 * another part. after: no contact. */
void haptable_surface_leave(const float x_m[3], struct haptable_segment* segment, struct haptable_contact* contact);

#endif
