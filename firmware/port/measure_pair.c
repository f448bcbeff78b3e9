/* SPDX-License-Identifier: MIT
 *
 * Like pair.c, with tables that it reads, as measure.c does of one finger. Its words: measure_pair IN OUT. IN holds the
 * model as codegen/model_bytes.cpp writes it, what couples two fingers as codegen/pair.cpp does, then the path.
 */
#include "haptable_model_reader.h"
#include "haptable_pair_reader.h"
#include "haptable_pair_ticks.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"

/* Where the tables go. */
static uint32_t room[384u * 1024u];
static struct haptable_model_reader reader;
static struct haptable_model model;
static struct haptable_pair_model pair_model;

static uint32_t read_file(void* file, void* to, uint32_t bytes) {
    return haptable_semihosting_read(*(const int*)file, to, bytes);
}

int haptable_port_main(void) {
    int in, out;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    reader.read = read_file;
    reader.from = &in;
    reader.room = room;
    reader.words = sizeof room / sizeof room[0];
    if (!haptable_read_model(&reader, &model) || !haptable_read_pair(&reader, &model, &pair_model)) return 65;
    haptable_pair_ticks_replay(&pair_model, in, out);
    return 0;
}
