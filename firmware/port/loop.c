/* SPDX-License-Identifier: MIT
 *
 * frames in -> haptable_step -> frames out, for ever
 *
 * The servo behind a serial line; here two files of the debugger's machine, which may be named pipes. Its words: loop
 * IN OUT. Time is that of the frames. A state that comes twice is answered twice and stepped once: a host that has
 * lost an answer asks again, and nothing changes.
 */
#include "frame.h"
#include "haptable.h"
#include "model.h"
#include "port.h"
#include "semihosting.h"

static struct haptable_servo servo_state;
static struct haptable_output output;
static struct frame_reader reader;

static void answer(const struct frame* frame, int out_file) {
    static uint32_t last_sequence;
    static uint32_t last_time_us;
    static int answered;
    struct frame_state state;
    uint8_t bytes[FRAME_BYTES];
    uint32_t length;
    if (!frame_take_state(frame, &state)) return;
    if (!answered || frame->sequence != last_sequence || state.time_us != last_time_us) {
        /* A gap in time drops the contact, as silence does. */
        haptable_watch(&servo_state, state.time_us, &output);
        haptable_step(&HAPTABLE_MODEL, &servo_state, state.position_m, state.time_us, &output);
    }
    answered = 1;
    last_sequence = frame->sequence;
    last_time_us = state.time_us;
    length = frame_write_force(frame->sequence, HAPTABLE_MODEL.hash, &output, bytes);
    semihosting_write(out_file, bytes, length);
}

int port_main(void) {
    static char text[512];
    const char* word[3] = {0, 0, 0};
    uint8_t byte;
    int in_file;
    int out_file;
    if (semihosting_words(text, sizeof text, word, 3) != 3) return 64;
    in_file = semihosting_open(word[1], SEMIHOSTING_READ);
    out_file = semihosting_open(word[2], SEMIHOSTING_WRITE);
    if (in_file < 0 || out_file < 0) return 66;
    haptable_init(&servo_state);
    frame_reader_init(&reader);
    while (semihosting_read(in_file, &byte, 1) == 1) {
        struct frame frame;
        if (frame_read(&reader, byte, &frame)) answer(&frame, out_file);
    }
    return 0;
}
