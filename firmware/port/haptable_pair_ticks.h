/* SPDX-License-Identifier: MIT
 *
 * positions (float32[2][3], raw) -> haptable_pair_step, a millisecond apart -> a record of both fingers a tick
 *
 * A record: of each finger state, patch, and the bits of alpha, god-object and force: 11 words.
 */
#ifndef HAPTABLE_PAIR_TICKS_H
#define HAPTABLE_PAIR_TICKS_H

#include "haptable_pair.h"

/* Steps two fresh servos through what is left of file `in`, between the marks of haptable_port.h, and writes the
 * records to `out`. */
void haptable_pair_ticks_replay(const struct haptable_pair_model* tables, int in, int out);

#endif
