/* SPDX-License-Identifier: MIT
 *
 * frames in -> haptable_step -> frames out, for ever
 *
 * The servo behind a serial line: loop.elf has two files of the debugger's machine as its line, uart.elf the part's
 * UART. Time is that of the frames. A state that comes twice is answered twice and stepped once: a host that has lost
 * an answer asks again, and nothing changes.
 */
#include "haptable.h"
#include "haptable_frame.h"
#include "haptable_line.h"
#include "haptable_port.h"
#include "model.h"

static struct haptable_servo servo_state;
static struct haptable_output output;
static struct haptable_frame_reader reader;

static void answer(const struct haptable_frame* frame) {
    static uint32_t last_sequence;
    static uint32_t last_time_us;
    static int answered;
    struct haptable_frame_state state;
    uint8_t bytes[HAPTABLE_FRAME_BYTES];
    uint32_t length;
    if (!haptable_frame_take_state(frame, &state)) return;
    if (!answered || frame->sequence != last_sequence || state.time_us != last_time_us) {
        /* A gap in time drops the contact, as silence does. */
        haptable_watch(&servo_state, state.time_us, &output);
        haptable_buttons(&servo_state, state.buttons);
        haptable_step(&HAPTABLE_MODEL, &servo_state, state.position_m, state.time_us, &output);
    }
    answered = 1;
    last_sequence = frame->sequence;
    last_time_us = state.time_us;
    length = haptable_frame_write_force(frame->sequence, HAPTABLE_MODEL.hash, &output, bytes);
    haptable_line_write(bytes, length);
    haptable_check(&HAPTABLE_MODEL, &servo_state, HAPTABLE_CHECK_BYTES);
}

int haptable_port_main(void) {
    const int status = haptable_line_open();
    uint8_t byte;
    if (status != 0) return status;
    haptable_init(&servo_state);
    haptable_check(&HAPTABLE_MODEL, &servo_state, HAPTABLE_CHECK_ALL);
    haptable_frame_reader_init(&reader);
    while (haptable_line_read(&byte)) {
        struct haptable_frame frame;
        if (haptable_frame_read(&reader, byte, &frame)) answer(&frame);
    }
    return 0;
}
