/* SPDX-License-Identifier: MIT
 *
 * What replay.c and measure.c share: a servo stepped through a path, and a tick as text.
 */
#include "haptable_ticks.h"

#include "haptable_port.h"
#include "haptable_semihosting.h"

#define POSITIONS 32 /* read at once: a call to the debugger costs more than a tick */

/* Text on its way out. */
static struct {
    int file;
    uint32_t length;
    char text[1024];
} out_file;

static void flush(void) {
    haptable_semihosting_write(out_file.file, out_file.text, out_file.length);
    out_file.length = 0;
}

static void put_hex(uint32_t bits, char after) {
    int shift;
    for (shift = 28; shift >= 0; shift -= 4)
        out_file.text[out_file.length++] = "0123456789abcdef"[(bits >> shift) & 15u];
    out_file.text[out_file.length++] = after;
}

static uint32_t bits_of(float number) {
    union {
        float number;
        uint32_t bits;
    } both;
    both.number = number;
    return both.bits;
}

static void put_floats(const float values[3], char last) {
    put_hex(bits_of(values[0]), ' ');
    put_hex(bits_of(values[1]), ' ');
    put_hex(bits_of(values[2]), last);
}

#define LINE_CHARS (13u * 9u)

static void put_tick(const struct haptable_output* out) {
    int corner;
    if (out_file.length + LINE_CHARS > sizeof out_file.text) flush();
    put_hex(out->state, ' ');
    for (corner = 0; corner < 3; ++corner) put_hex(out->vertex[corner], ' ');
    put_floats(out->alpha, ' ');
    put_floats(out->god_object_m, ' ');
    put_floats(out->force_n, '\n');
}

static struct haptable_servo servo_state;

void haptable_ticks_replay(const struct haptable_model* model, int in, int out) {
    float position_m[POSITIONS][3];
    uint32_t now_us = 0;
    uint32_t bytes;
    out_file.file = out;
    haptable_init(&servo_state);
    haptable_check(model, &servo_state, HAPTABLE_CHECK_ALL);
    while ((bytes = haptable_semihosting_read(in, position_m, sizeof position_m)) > 0) {
        uint32_t i;
        for (i = 0; i < bytes / sizeof position_m[0]; ++i, now_us += HAPTABLE_TICK_US) {
            struct haptable_output tick;
            haptable_port_count_begin();
            haptable_step(model, &servo_state, position_m[i], now_us, &tick);
            haptable_port_count_end();
            put_tick(&tick);
        }
    }
    flush();
}
