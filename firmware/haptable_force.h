/* SPDX-License-Identifier: MIT
 *
 * The device's limits: of a force, and of a brake.
 */
#ifndef HAPTABLE_FORCE_H
#define HAPTABLE_FORCE_H

#include "haptable_model.h"

/* Cuts the force to max_n, keeping its direction. Returns 1 when it was cut.
 * before: force_n is finite, max_n > 0. after: |force_n| <= max_n to rounding. */
int haptable_force_clamp(float max_n, float force_n[3]);

/* A brake resists by no more than this times the stiffest contact, K: as a damper of 64 K T that comes a tick late. A
 * mass of 64 K T^2 bears that, 64 g at 1000 N/m. One that took back all that was given of a finger that hardly moves
 * would throw it about. */
#define HAPTABLE_BRAKE 64.0f

/* N/m, against a tick's motion: what takes given_j back in the next one, if the finger goes on as it went. */
float haptable_brake_of(const struct haptable_model* model, float given_j, float motion2_m2);

/* The brake, N/m, or what of it gives max_force_n over that motion. before: by >= 0 */
float haptable_brake_within(const struct haptable_model* model, float by, float motion2_m2);

/* Brakes by so much. */
void haptable_brake(const struct haptable_model* model, float by, const float motion_m[3], float force_n[3]);

#endif
