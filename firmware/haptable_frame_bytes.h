/* SPDX-License-Identifier: MIT
 *
 * Numbers in frames, little-endian on every machine. Inlined: haptable_frame.c and haptable_frame_body.c are its only
 * users.
 */
#ifndef HAPTABLE_FRAME_BYTES_H
#define HAPTABLE_FRAME_BYTES_H

#include <stdint.h>

static inline uint8_t* frame_put_word(uint8_t* to, uint32_t word) {
    to[0] = (uint8_t)word;
    to[1] = (uint8_t)(word >> 8);
    to[2] = (uint8_t)(word >> 16);
    to[3] = (uint8_t)(word >> 24);
    return to + 4;
}

static inline uint32_t frame_word_at(const uint8_t* from) {
    return (uint32_t)from[0] | ((uint32_t)from[1] << 8) | ((uint32_t)from[2] << 16) | ((uint32_t)from[3] << 24);
}

union frame_number {
    float value;
    uint32_t bits;
};

static inline uint8_t* frame_put_floats(uint8_t* to, const float* values, int count) {
    int i;
    for (i = 0; i < count; ++i) {
        union frame_number number;
        number.value = values[i];
        to = frame_put_word(to, number.bits);
    }
    return to;
}

static inline const uint8_t* frame_take_floats(const uint8_t* from, float* values, int count) {
    int i;
    for (i = 0; i < count; ++i, from += 4) {
        union frame_number number;
        number.bits = frame_word_at(from);
        values[i] = number.value;
    }
    return from;
}

#endif
