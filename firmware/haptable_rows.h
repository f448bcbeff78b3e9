/* SPDX-License-Identifier: MIT
 *
 * The compliance of one contact, three rows: what haptable_rows_of_one and haptable_rows_of_two are made of.
 */
#ifndef HAPTABLE_ROWS_H
#define HAPTABLE_ROWS_H

#include "haptable_scene.h"

/* Rows 3 finger and on of a[][]: C of that finger's contact alone, as its force was given. Returns 1 where it presses;
 * 0, and 1 on the diagonal, where not. */
int haptable_rows_alone(const struct haptable_model* model, const struct haptable_servo* servo, int finger,
                        const float load_n[3], float (*a)[HAPTABLE_ROWS]);

#endif
