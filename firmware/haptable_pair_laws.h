/* SPDX-License-Identifier: MIT
 *
 * What the linear laws of two fingers are made of, for those whose dents stiffen to call
 */
#ifndef HAPTABLE_PAIR_LAWS_H
#define HAPTABLE_PAIR_LAWS_H

#include "haptable_law.h"

#define HAPTABLE_PAIR_LAW(name)                    \
    haptable_pair_own_fn haptable_pair_own_##name; \
    haptable_pair_open_fn haptable_pair_open_##name;
HAPTABLE_PAIR_LAWS(HAPTABLE_PAIR_LAW)
#undef HAPTABLE_PAIR_LAW

haptable_pair_load_fn haptable_pair_load_interpolated;
haptable_pair_slope_fn haptable_pair_slope_interpolated;

#endif
