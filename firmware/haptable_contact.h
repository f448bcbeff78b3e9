/* SPDX-License-Identifier: MIT
 *
 * The god-object of Zilles and Salisbury (1995) on a closed triangle surface. A pure function of the tables, the
 * previous contact and the finger's motion: no state of its own, no drawing, no input or output.
 */
#ifndef HAPTABLE_CONTACT_H
#define HAPTABLE_CONTACT_H

#include "haptable.h"

/* Slides the god-object down to the nearest point of the surface around it; *steps counts on. Returns 0 when it met
 * HAPTABLE_WALK_STEPS and is not there yet.
 * before: contact holds a point of the surface. */
int haptable_contact_slide(const struct haptable_model* model, const float x_m[3], struct haptable_contact* contact,
                           int* steps);

#endif
