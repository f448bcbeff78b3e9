/* SPDX-License-Identifier: MIT
 *
 * Where a segment first enters the surface: a finger's path, or the line from the surface to the finger.
 */
#ifndef HAPTABLE_ENTRY_H
#define HAPTABLE_ENTRY_H

#include "haptable_model.h"

/* Begins contact where the finger, now at x_m, first crossed the surface inwards: the first patch that its segment
 * enters, by the spatial index. First the segment that is not finished, if there is one, then from its end to x_m.
 * Returns 0, and leaves the contact, when it enters none as far as the tick's boxes go. after: contact, or the segment
 * up to x_m is searched, or segment->unfinished and box_limits counted. cost: at most HAPTABLE_TICK_BOXES boxes for all
 * calls of one tick.
 * Where segment->fraction is negative, no surface lies within -fraction, m, of segment->from_m: a search that found
 * nothing says so, and as long as the finger stays within, there is none and nothing changes but to_m. */
int haptable_surface_enter(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]);

/* The contact where the segment enters, which begins. before: segment->patch is not HAPTABLE_NONE. */
void haptable_segment_entry(const struct haptable_model* model, const struct haptable_segment* segment,
                            struct haptable_contact* contact);

/* Sets the end of a segment that enters nothing back by tolerance_m: there it is outside for sure, while its end may
 * lie a rounding behind a patch, and a path from there would enter none. */
void haptable_segment_step_back(const struct haptable_model* model, struct haptable_segment* segment);

/* How a finger is seen from a point of the surface. */
enum haptable_sight {
    HAPTABLE_SIGHT_INSIDE,    /* not: the line to it begins within the body, or is no longer than tolerance_m */
    HAPTABLE_SIGHT_CLEAR,     /* through free air: the finger is outside */
    HAPTABLE_SIGHT_BLOCKED,   /* not: the line to it enters the body, where segment says */
    HAPTABLE_SIGHT_UNFINISHED /* the tick's boxes were too few: segment is to be searched on */
};

/* Looks from `from` to the finger at x_m, as far as the tick has boxes. after, unless the line begins inside: the
 * servo's segment is that line. */
enum haptable_sight haptable_surface_sight(const struct haptable_model* model, struct haptable_servo* servo,
                                           const struct haptable_contact* from, const float x_m[3]);

/* Goes on with a look that is not finished. before: segment->unfinished. */
enum haptable_sight haptable_segment_search(const struct haptable_model* model, struct haptable_servo* servo);

#endif
