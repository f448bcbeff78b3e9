/* SPDX-License-Identifier: MIT
 *
 * Like replay.c, with a model that it reads instead of one that it is linked with: every mode of the servo on every
 * body from one image, for tests and counts. Its words: measure IN OUT. IN holds the model as codegen/model_bytes.cpp
 * writes it, then the path. The tables lie in RAM: for boards like QEMU's, with megabytes of it.
 */
#include "haptable.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "haptable_ticks.h"

/* Where the tables go: mask tables of a body of 2,400 patches take half a megabyte. */
static uint32_t arena[256u * 1024u];
static uint32_t used;
static struct haptable_compliance compliance;
static struct haptable_model model;

/* The file, and whether all that was asked of it came and had room. */
static struct {
    int file;
    int is_whole;
} in;

static void take(void* to, uint32_t bytes) {
    if (haptable_semihosting_read(in.file, to, bytes) != bytes) in.is_whole = 0;
}

static uint32_t take_word(void) {
    uint32_t word = 0;
    take(&word, sizeof word);
    return word;
}

/* A table after its number of rows; every one begins at a whole word. */
static void* take_table(uint32_t row_bytes) {
    uint32_t* table = &arena[used];
    const uint32_t rows = take_word();
    if (rows > (sizeof arena - sizeof arena[0] * used) / row_bytes) in.is_whole = 0;
    if (rows == 0 || !in.is_whole) return 0;
    take(table, rows * row_bytes);
    used += (rows * row_bytes + 3u) / 4u;
    return table;
}

/* The number of a function: 0 for none, and below `choices`. */
static uint32_t take_choice(uint32_t choices) {
    const uint32_t choice = take_word();
    if (choice < choices) return choice;
    in.is_whole = 0;
    return 0;
}

#define TAKE_VALUE(type, name) take(&to->name, sizeof to->name);
#define TAKE_TABLE(type, name, count) to->name = take_table(sizeof *to->name);
#define CHOICE(function) function,
#define TAKE_FUNCTION(type, name, choices)                                \
    {                                                                     \
        static type* const choice[] = {0, choices(CHOICE)};               \
        to->name = choice[take_choice(sizeof choice / sizeof choice[0])]; \
    }
#define TAKE_PART(type, name) \
    if (take_word()) to->name = take_##name(&name);

static const struct haptable_compliance* take_compliance(struct haptable_compliance* to) {
    HAPTABLE_COMPLIANCE_FIELDS(TAKE_VALUE, TAKE_TABLE)
    return to;
}

static void take_model(struct haptable_model* to) {
    HAPTABLE_MODEL_FIELDS(TAKE_VALUE, TAKE_TABLE, TAKE_FUNCTION, TAKE_PART)
}

int haptable_port_main(void) {
    int out;
    const int status = haptable_semihosting_files(&in.file, &out);
    if (status != 0) return status;
    in.is_whole = 1;
    take_model(&model);
    if (!in.is_whole) return 65;
    haptable_ticks_replay(&model, in.file, out);
    return 0;
}
