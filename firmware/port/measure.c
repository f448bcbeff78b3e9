/* SPDX-License-Identifier: MIT
 *
 * Like replay.c, with a model that it reads instead of one that it is linked with: every mode of the servo on every
 * body from one image, for tests and counts. Its words: measure IN OUT. IN holds the model as codegen/model_bytes.cpp
 * writes it, then the path. The tables lie in RAM: for boards like QEMU's, with megabytes of it.
 */
#include "haptable_model_reader.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "haptable_ticks.h"

/* Where the tables go: mask tables of a body of 2,400 patches take half a megabyte. */
static uint32_t room[256u * 1024u];
static struct haptable_model_reader reader;
static struct haptable_model model;

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
    if (!haptable_read_model(&reader, &model)) return 65;
    haptable_ticks_replay(&model, in, out);
    return 0;
}
