/* SPDX-License-Identifier: MIT
 *
 * The paper's force, equations 9 to 12.
 */
#ifndef HAPTABLE_FORCE_H
#define HAPTABLE_FORCE_H

#include "haptable.h"

/* Nodal forces F_i = alpha_i S_i u on the contact's patch (eq. 9, 10), u = finger - god-object, and the reaction
 * -(F_i + F_j + F_k) that the user feels (eq. 12), not yet clamped. A fixed vertex has S = rigid_stiffness I.
 * before: contact->patch < patch_count. cost: three symmetric 3x3 products. */
void force_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                        const float finger_m[3], float nodal_force_n[3][3], float force_n[3]);

/* Cuts the force to max_n, keeping its direction. Returns 1 when it was cut.
 * before: force_n is finite, max_n > 0. after: |force_n| <= max_n to rounding. */
int force_clamp(float max_n, float force_n[3]);

#endif
