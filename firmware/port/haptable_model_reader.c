/* SPDX-License-Identifier: MIT */
#include "haptable_model_reader.h"

static void take(struct haptable_model_reader* in, void* to, uint32_t bytes) {
    if (in->read(in->from, to, bytes) != bytes) in->is_whole = 0;
}

static uint32_t take_word(struct haptable_model_reader* in) {
    uint32_t word = 0;
    take(in, &word, sizeof word);
    return word;
}

/* A table after its number of rows; every one begins at a whole word. */
static void* take_table(struct haptable_model_reader* in, uint32_t row_bytes) {
    uint32_t* table = in->room + in->used_words;
    const uint32_t rows = take_word(in);
    if (rows > (in->words - in->used_words) * (uint32_t)sizeof *table / row_bytes) in->is_whole = 0;
    if (rows == 0 || !in->is_whole) return 0;
    take(in, table, rows * row_bytes);
    in->used_words += (rows * row_bytes + 3u) / 4u;
    return table;
}

/* The number of a function: 0 for none, and below `choices`. */
static uint32_t take_choice(struct haptable_model_reader* in, uint32_t choices) {
    const uint32_t choice = take_word(in);
    if (choice < choices) return choice;
    in->is_whole = 0;
    return 0;
}

#define TAKE_VALUE(type, name) take(in, &to->name, sizeof to->name);
#define TAKE_TABLE(type, name, count) to->name = take_table(in, sizeof *to->name);
#define CHOICE(function) function,
#define TAKE_FUNCTION(type, name, choices)                                    \
    {                                                                         \
        static type* const choice[] = {0, choices(CHOICE)};                   \
        to->name = choice[take_choice(in, sizeof choice / sizeof choice[0])]; \
    }
#define TAKE_PART(type, name) \
    if (take_word(in)) to->name = take_##name(in, &in->name);

static const struct haptable_compliance* take_compliance(struct haptable_model_reader* in,
                                                         struct haptable_compliance* to) {
    HAPTABLE_COMPLIANCE_FIELDS(TAKE_VALUE, TAKE_TABLE)
    return to;
}

void haptable_reader_take(struct haptable_model_reader* in, void* to, uint32_t bytes) { take(in, to, bytes); }

void* haptable_reader_table(struct haptable_model_reader* in, uint32_t row_bytes) { return take_table(in, row_bytes); }

int haptable_read_model(struct haptable_model_reader* in, struct haptable_model* to) {
    in->is_whole = 1;
    to->compliance = 0;
    to->relaxed = &in->relaxed;
    HAPTABLE_MODEL_FIELDS(TAKE_VALUE, TAKE_TABLE, TAKE_FUNCTION, TAKE_PART)
    to->freed = to->frictionless ? &in->freed : 0;
    return in->is_whole;
}
