/* SPDX-License-Identifier: MIT
 *
 * The nearest point of one patch, which entering the surface and sliding on it both need, and of its border.
 */
#ifndef HAPTABLE_PATCH_H
#define HAPTABLE_PATCH_H

#include "haptable.h"

/* The area coordinates (eq. 11) and the position of the point of a patch that is nearest to x.
 * after: 0 <= alpha <= 1, sum 1 to rounding; alpha is exactly 0 at the corners opposite to the edges it lies on. */
void haptable_patch_nearest(const struct haptable_model* model, uint16_t patch, const float x_m[3],
                            struct haptable_contact* nearest);

/* A point whose area coordinates are no less is farther from the border than 8 tolerance_m, or its patch is thinner
 * than diagonal / 8192. */
#define HAPTABLE_NEAR_BORDER 0.0625f

static inline int haptable_patch_is_near_border(const struct haptable_contact* point) {
    const float* alpha = point->alpha;
    return alpha[0] < HAPTABLE_NEAR_BORDER || alpha[1] < HAPTABLE_NEAR_BORDER || alpha[2] < HAPTABLE_NEAR_BORDER;
}

/* Puts a point of a patch that is next to an edge or a vertex, within 8 tolerance_m, onto that: what lies there is to
 * be asked what is inside and what is outside. Returns 0, and leaves the point, where it is farther from both. after:
 * alpha as above. */
int haptable_patch_onto_border(const struct haptable_model* model, struct haptable_contact* point);

/* The corner whose opposite edge is as near to a point of the edge opposite to `corner`; -1: both are farther, the
 * patch is not that thin there. */
int haptable_patch_ends_beyond(const struct haptable_model* model, uint16_t patch, int corner, const float at_m[3]);

#endif
