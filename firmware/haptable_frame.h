/* SPDX-License-Identifier: MIT
 *
 * Frames on a serial line between the servo and a host: docs/SPEC.md describes every byte.
 *
 *   A5 5A | length | type | sequence (4) | payload (length) | CRC-32 of all before it but the first two (4)
 *
 * Little-endian. No interrupts and no buffers of a driver here: bytes go in one by one, frames come out.
 */
#ifndef HAPTABLE_FRAME_H
#define HAPTABLE_FRAME_H

#include <stdint.h>

#include "haptable.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTABLE_FRAME_PAYLOAD HAPTABLE_FRAME_FORCE_PAYLOAD /* the longest payload, bytes */
#define HAPTABLE_FRAME_BYTES (12 + HAPTABLE_FRAME_PAYLOAD)  /* the longest frame */
#define HAPTABLE_FRAME_STATE 1 /* to the servo: time_us u32, position_m f32[3], buttons u32 */
#define HAPTABLE_FRAME_STATE_PAYLOAD 20
#define HAPTABLE_FRAME_FORCE 2 /* from the servo: see haptable_frame_write_force */
#define HAPTABLE_FRAME_FORCE_PAYLOAD 88

/* The receiving end of a line. */
struct haptable_frame_reader {
    uint8_t byte[HAPTABLE_FRAME_BYTES]; /* what has come of a frame, and what came after a false begin */
    uint8_t count;                      /* of them */
    uint32_t frames;                    /* whole ones */
    uint32_t skipped_bytes;             /* that belonged to none */
};

/* A whole frame. The payload points into the reader and is valid until its next byte. */
struct haptable_frame {
    uint8_t type;
    uint8_t length;
    uint32_t sequence;
    const uint8_t* payload;
};

/* A finger's position, for the servo. */
struct haptable_frame_state {
    uint32_t time_us;
    float position_m[3];
    uint32_t buttons; /* enum haptable_button */
};

void haptable_frame_reader_init(struct haptable_frame_reader* reader);

/* Takes one byte. Returns 1 when it completed a frame whose length and CRC are right; then frame holds it.
 * After garbage it finds the next whole frame: a false begin costs only its own first byte, so a frame that begins
 * inside it is not lost. cost: at most HAPTABLE_FRAME_BYTES searches of one CRC each, on average a byte of a CRC. */
int haptable_frame_read(struct haptable_frame_reader* reader, uint8_t byte, struct haptable_frame* frame);

/* 1 when the frame is a state; then state holds it. */
int haptable_frame_take_state(const struct haptable_frame* frame, struct haptable_frame_state* state);

/* Write whole frames to bytes; return their length. */
uint32_t haptable_frame_write_state(uint32_t sequence, const struct haptable_frame_state* state,
                                    uint8_t bytes[HAPTABLE_FRAME_BYTES]);
uint32_t haptable_frame_write_force(uint32_t sequence, uint64_t model_hash, const struct haptable_output* out,
                                    uint8_t bytes[HAPTABLE_FRAME_BYTES]);

/* 1 when the frame is a force; then *model_hash and all of out but patch hold it. */
int haptable_frame_take_force(const struct haptable_frame* frame, uint64_t* model_hash, struct haptable_output* out);

#ifdef __cplusplus
}
#endif

#endif
