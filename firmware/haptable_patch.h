/* SPDX-License-Identifier: MIT
 *
 * The nearest point of one patch: entering the surface and sliding on it both need it.
 */
#ifndef HAPTABLE_PATCH_H
#define HAPTABLE_PATCH_H

#include "haptable.h"

/* The area coordinates (eq. 11) and the position of the point of a patch that is nearest to x.
 * after: 0 <= alpha <= 1, sum 1 to rounding; alpha is exactly 0 at the corners opposite to the edges it lies on. */
void haptable_patch_nearest(const struct haptable_model* model, uint16_t patch, const float x_m[3],
                            struct haptable_contact* nearest);

#endif
