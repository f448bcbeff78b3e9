/* SPDX-License-Identifier: MIT
 *
 * A model that is read instead of linked: its bytes are those of codegen/model_bytes.cpp. All functions that a model
 * can name are linked with it. For images that feel any body: tests, and the page in a browser.
 */
#ifndef HAPTABLE_MODEL_READER_H
#define HAPTABLE_MODEL_READER_H

#include "haptable.h"

/* Where the bytes come from and where the tables go. */
struct haptable_model_reader {
    uint32_t (*read)(void* from, void* to, uint32_t bytes); /* gives how many came */
    void* from;
    uint32_t* room;                        /* for the tables; outlives the model */
    uint32_t words;                        /* of room */
    uint32_t used_words;                   /* 0 at first */
    int is_whole;                          /* set by the reader */
    struct haptable_compliance compliance; /* that the model points to */
    struct haptable_relaxed relaxed;       /* the same */
    struct haptable_freed freed;           /* the same, with friction */
    struct haptable_freed freed_of_second; /* of two fingers */
};

/* Fills in all of *to but its hash, which is not among the bytes. Returns 1, or 0 where the bytes end too early, name a
 * function that there is not, or need more room. The model points into the reader and its room. */
int haptable_read_model(struct haptable_model_reader* reader, struct haptable_model* to);

/* The next bytes, and a table of rows after their number, for what stands behind a model. Where there are too few the
 * reader is not whole. */
void haptable_reader_take(struct haptable_model_reader* reader, void* to, uint32_t bytes);
void* haptable_reader_table(struct haptable_model_reader* reader, uint32_t row_bytes);

#endif
