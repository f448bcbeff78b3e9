/* SPDX-License-Identifier: MIT
 *
 * The serial line between a servo and a host: docs/SPEC.md describes every byte.
 *
 *   A5 5A | length (2) | type (1) | sequence (4) | payload (length) | CRC-32 of all before it but the first two (4)
 *
 * Little-endian. A hello says what a scene is; the length of a tick's frames, one each way, follows from it. No
 * interrupts and no buffers of a driver here: bytes go in one by one, frames come out. haptable.h has what a board
 * calls.
 */
#ifndef HAPTABLE_LINE_H
#define HAPTABLE_LINE_H

#include "haptable.h"
#include "haptable_scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Version of the protocol: both ends must have the same. */
#define HAPTABLE_LINE_VERSION 3

/* Frame types. */
#define HAPTABLE_LINE_HELLO 10  /* either way: struct haptable_line_hello; a host's asks for the target's */
#define HAPTABLE_LINE_STATE 11  /* to the servo: struct haptable_line_state */
#define HAPTABLE_LINE_ANSWER 12 /* from the servo: struct haptable_line_answer; its sequence is the state's */

/* Bits of a hello's flags. */
enum haptable_line_flag {
    HAPTABLE_LINE_FREE = 1,           /* free body: an answer holds its pose */
    HAPTABLE_LINE_GRABS = 2,          /* HAPTABLE_BUTTON_GRAB holds on to the surface */
    HAPTABLE_LINE_TOOL = 4,           /* the hand holds a tool: frames of haptable_line_points.h */
    HAPTABLE_LINE_OTHER_VERSION = 128 /* the host's version differs: the target answers none of its ticks */
};

/* Description of one end. If its version differs, the other members are undefined. */
struct haptable_line_hello {
    uint8_t version; /* HAPTABLE_LINE_VERSION */
    uint8_t fingers; /* 1 to HAPTABLE_HANDS */
    uint8_t modes;   /* <= HAPTABLE_MODES; 0: quasi-static */
    uint8_t flags;   /* enum haptable_line_flag */
    uint64_t hash;   /* of the model's tables */
};

/* Input of a tick. */
struct haptable_line_state {
    uint32_t time_us; /* wraps */
    uint8_t begins;   /* a bit for each finger that is reset and loses its contact */
    struct haptable_input in[HAPTABLE_FINGERS];
};

/* Output of a tick. */
struct haptable_line_answer {
    struct haptable_output out[HAPTABLE_FINGERS]; /* without `patch`; in body axes but for the force */
    struct haptable_body_pose pose;               /* at the start of the tick: the frame of the contacts */
    float q[HAPTABLE_MODES];                      /* at the end of the tick */
};

/* A whole frame. The payload points into the reader's bytes and is valid until the next one. */
struct haptable_line_frame {
    uint8_t type;
    uint16_t length; /* of the payload */
    uint32_t sequence;
    uint8_t* payload;
};

/* ---- both ends, and the host's --------------------------------------------------------------------------------- */

/* byte, room: for frames of up to so many bytes; outlives the reader. */
void haptable_line_reader_init(uint8_t* byte, uint16_t room, struct haptable_line_reader* reader);

/* Takes one byte. Returns 1 when it completed a frame whose length and CRC are right; then frame holds it.
 * After garbage it finds the next whole frame: a false begin costs only its own first byte, so a frame that begins
 * inside it is not lost. cost: at most reader->room searches of one CRC each, on average a byte of a CRC. */
int haptable_line_read(struct haptable_line_reader* reader, uint8_t byte, struct haptable_line_frame* frame);

/* Writes the description of a scene. */
void haptable_line_describe(const struct haptable_scene* scene, struct haptable_line_hello* hello);

/* 1 when the frame is one of that kind, of the scene that hello describes; then the last argument holds it. Of a hello
 * of another version that is its version alone. */
int haptable_line_take_hello(const struct haptable_line_frame* frame, struct haptable_line_hello* hello);
int haptable_line_take_state(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                             struct haptable_line_state* state);
int haptable_line_take_answer(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                              struct haptable_line_answer* answer);

/* Write whole frames to bytes; return their length. */
uint32_t haptable_line_write_hello(uint32_t sequence, struct haptable_line_hello hello,
                                   uint8_t bytes[HAPTABLE_LINE_HELLO_BYTES]);
uint32_t haptable_line_write_state(uint32_t sequence, const struct haptable_line_hello* hello,
                                   struct haptable_line_state state, uint8_t bytes[HAPTABLE_LINE_STATE_BYTES]);
uint32_t haptable_line_write_answer(uint32_t sequence, const struct haptable_line_hello* hello,
                                    struct haptable_line_answer* answer, uint8_t bytes[HAPTABLE_LINE_ANSWER_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
