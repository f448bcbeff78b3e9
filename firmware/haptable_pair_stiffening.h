/* SPDX-License-Identifier: MIT
 *
 * How a contact's u is stretched to v = r u: haptable_pair_stiffening.c has the law.
 */
#ifndef HAPTABLE_PAIR_STIFFENING_H
#define HAPTABLE_PAIR_STIFFENING_H

#include "haptable_pair_terms.h"

/* Of a contact alone: q = C^-1 u, work_j = 2 e = u . q and 1 / that, or 0; r, k = 2 e dr/de, m = 4 e^2 d2r/de2. */
struct stretch {
    float u[3];
    float q[3];
    float work_j, per_j;
    float r, k, m;
};

/* Of u by the contact's A, a stiffness or a compliance. */
void haptable_pair_stretch(const struct haptable_model* model, const float a[6], int is_stiffness, const float u[3],
                           struct stretch* to);

#endif
