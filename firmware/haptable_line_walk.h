/* SPDX-License-Identifier: MIT
 *
 * values <-> bytes of a frame
 *
 * What the line of one finger or two (haptable_line.c) and that of more (haptable_line_points.c) share.
 */
#ifndef HAPTABLE_LINE_WALK_H
#define HAPTABLE_LINE_WALK_H

#include "haptable.h"
#include "haptable_crc.h"

#define HAPTABLE_LINE_SYNC 0x5AA5u /* A5 5A */
#define HAPTABLE_LINE_HEAD 9u      /* bytes before the payload */
#define HAPTABLE_LINE_TAIL 4u      /* bytes after it */

/* Each payload is said once: a walk over its bytes reads or writes it. */
struct walk {
    uint8_t* at;
    int is_read; /* 1: bytes become values; 0: values become bytes */
};

static uint32_t walk_bits(struct walk* walk, uint32_t bits, uint32_t bytes) {
    uint32_t read = 0;
    for (uint32_t i = 0; i < bytes; ++i, ++walk->at) {
        if (!walk->is_read) *walk->at = (uint8_t)(bits >> (8u * i));
        read |= (uint32_t)*walk->at << (8u * i);
    }
    return read;
}

static void walk_byte(struct walk* walk, uint8_t* value) { *value = (uint8_t)walk_bits(walk, *value, 1); }

static void walk_half(struct walk* walk, uint16_t* value) { *value = (uint16_t)walk_bits(walk, *value, 2); }

static void walk_word(struct walk* walk, uint32_t* value) { *value = walk_bits(walk, *value, 4); }

static void walk_floats(struct walk* walk, float* values, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
        union {
            float value;
            uint32_t bits;
        } number;
        number.value = values[i];
        number.bits = walk_bits(walk, number.bits, 4);
        values[i] = number.value;
    }
}

static void walk_output(struct walk* walk, struct haptable_output* out) {
    walk_byte(walk, &out->state);
    walk_byte(walk, &out->faults);
    for (int corner = 0; corner < 3; ++corner) walk_half(walk, &out->vertex[corner]);
    walk_floats(walk, out->force_n, 3);
    walk_floats(walk, out->god_object_m, 3);
    walk_floats(walk, out->alpha, 3);
    for (int corner = 0; corner < 3; ++corner) walk_floats(walk, out->nodal_force_n[corner], 3);
}

static uint32_t crc_of(const uint8_t* bytes, uint32_t count) { return ~haptable_crc(HAPTABLE_CRC_BEGIN, bytes, count); }

static struct walk begin_frame(uint8_t type, uint32_t sequence, uint8_t* bytes) {
    struct walk walk = {bytes, 0};
    (void)walk_bits(&walk, HAPTABLE_LINE_SYNC, 4);
    (void)walk_bits(&walk, type, 1);
    (void)walk_bits(&walk, sequence, 4);
    return walk;
}

static uint32_t end_frame(struct walk walk, uint8_t* bytes) {
    const uint32_t before_crc = (uint32_t)(walk.at - bytes);
    struct walk length = {bytes + 2, 0};
    (void)walk_bits(&length, before_crc - HAPTABLE_LINE_HEAD, 2);
    (void)walk_bits(&walk, crc_of(bytes + 2, before_crc - 2u), 4);
    return before_crc + HAPTABLE_LINE_TAIL;
}

#endif
