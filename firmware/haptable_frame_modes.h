/* SPDX-License-Identifier: MIT
 *
 * A body that rings on a serial line, held and under one finger: frames of haptable_frame.h, and before the force of
 * each tick how far its modes have swung.
 *
 *   bytes -> frames -> state -> haptable_modes_step -> modes, force -> bytes
 *
 * An entry of its own: where no program calls it, nothing of it is linked. docs/SPEC.md describes every byte.
 */
#ifndef HAPTABLE_FRAME_MODES_H
#define HAPTABLE_FRAME_MODES_H

#include "haptable_frame.h"
#include "haptable_modes.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTABLE_FRAME_MODES 9 /* from the servo: f32 of each mode */
#define HAPTABLE_FRAME_MODES_BYTES (12 + 4 * HAPTABLE_MODES)

/* The longest answer: how far the modes have swung, and a force. */
#define HAPTABLE_FRAME_RINGING_BYTES (HAPTABLE_FRAME_MODES_BYTES + HAPTABLE_FRAME_BYTES)

/* Writes a whole frame to bytes: q of `count` modes. Returns its length. before: count <= HAPTABLE_MODES. */
uint32_t haptable_frame_write_modes(uint32_t sequence, const float* q, uint8_t count,
                                    uint8_t bytes[HAPTABLE_FRAME_MODES_BYTES]);

/* How many modes the frame is of, whose q is in swings then; 0: it is another frame. */
uint8_t haptable_frame_take_modes(const struct haptable_frame* frame, struct haptable_swings* swings);

/* The servo's end of a line. The caller owns it; haptable_frame_modes_init makes it valid. */
struct haptable_frame_modes {
    struct haptable_servo servo;
    struct haptable_output out; /* of the last tick */
    struct haptable_modes_state state;
    struct haptable_frame_reader reader;
    uint32_t sequence;  /* of that tick */
    uint32_t time_us;   /* the same */
    uint8_t is_stepped; /* 0: there was none yet */
};

/* No tick, no contact, the tables checked, the body at rest. */
void haptable_frame_modes_init(const struct haptable_modes* modes, struct haptable_frame_modes* line);

/* Takes one byte. Returns how many bytes of an answer are to be sent: 0 but where it completes a state. One that comes
 * twice is answered twice and stepped once. Between ticks the caller goes on with haptable_check. cost:
 * haptable_frame_read's; with a state haptable_modes_step's, and the CRCs of both frames. */
uint32_t haptable_frame_modes_take(const struct haptable_modes* modes, struct haptable_frame_modes* line, uint8_t byte,
                                   uint8_t answer[HAPTABLE_FRAME_RINGING_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
