/* SPDX-License-Identifier: MIT
 *
 * positions (float32[3], raw) -> haptable_step, a millisecond apart -> one line of bits a tick
 *
 * A line: state, three vertices, then the bits of alpha, god-object and force, all in hexadecimal, blanks between.
 */
#ifndef HAPTABLE_TICKS_H
#define HAPTABLE_TICKS_H

#include "haptable.h"

/* Steps a fresh servo through what is left of file `in`, between the marks of haptable_port.h, and writes the lines to
 * `out`. */
void haptable_ticks_replay(const struct haptable_model* model, int in, int out);

#endif
