/* SPDX-License-Identifier: MIT
 *
 * positions (float32[3], raw) -> haptable_step, a millisecond apart -> one line of bits a tick
 *
 * The image that shows that a target computes what the host computes. Its words: replay IN OUT, files by semihosting.
 * A line: state, three vertices, then the bits of alpha, god-object and force, all in hexadecimal, blanks between.
 */
#include "haptable.h"
#include "model.h"
#include "port.h"
#include "semihosting.h"

#define TICK_US 1000u
#define POSITIONS 32 /* read at once: a call to the debugger costs more than a tick */

/* Text on its way out. */
static struct {
    int file;
    uint32_t length;
    char text[1024];
} out_file;

static void flush(void) {
    semihosting_write(out_file.file, out_file.text, out_file.length);
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

static void replay(int in) {
    float position_m[POSITIONS][3];
    uint32_t now_us = 0;
    uint32_t bytes;
    haptable_init(&servo_state);
    while ((bytes = semihosting_read(in, position_m, sizeof position_m)) > 0) {
        uint32_t i;
        for (i = 0; i < bytes / sizeof position_m[0]; ++i, now_us += TICK_US) {
            struct haptable_output out;
            port_count_begin();
            haptable_step(&HAPTABLE_MODEL, &servo_state, position_m[i], now_us, &out);
            port_count_end();
            put_tick(&out);
        }
    }
}

int port_main(void) {
    static char text[512];
    const char* word[3] = {0, 0, 0};
    int in;
    if (semihosting_words(text, sizeof text, word, 3) != 3) return 64;
    in = semihosting_open(word[1], SEMIHOSTING_READ);
    out_file.file = semihosting_open(word[2], SEMIHOSTING_WRITE);
    if (in < 0 || out_file.file < 0) return 66;
    replay(in);
    flush();
    return 0;
}
