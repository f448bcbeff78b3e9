/* SPDX-License-Identifier: MIT
 *
 * The device's limit.
 */
#ifndef HAPTABLE_FORCE_H
#define HAPTABLE_FORCE_H

/* Cuts the force to max_n, keeping its direction. Returns 1 when it was cut.
 * before: force_n is finite, max_n > 0. after: |force_n| <= max_n to rounding. */
int haptable_force_clamp(float max_n, float force_n[3]);

#endif
