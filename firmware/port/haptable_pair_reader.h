/* SPDX-License-Identifier: MIT
 *
 * What couples two fingers, read instead of linked, behind its model: see haptable_model_reader.h.
 */
#ifndef HAPTABLE_PAIR_READER_H
#define HAPTABLE_PAIR_READER_H

#include "haptable_model_reader.h"
#include "haptable_pair.h"

/* before: `model` was read from the same bytes. Fills in all of *to, with the functions that the model asks for.
 * Returns 1, or 0 as haptable_read_model. */
int haptable_read_pair(struct haptable_model_reader* reader, const struct haptable_model* model,
                       struct haptable_pair_model* to);

#endif
