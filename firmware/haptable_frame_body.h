/* SPDX-License-Identifier: MIT
 *
 * A body that nothing holds on a serial line: frames of haptable_frame.h, and before the force of each tick where the
 * body is in it.
 *
 *   bytes -> frames -> state -> haptable_body_step -> pose, force -> bytes
 *
 * An entry of its own: where no program calls it, nothing of it is linked. docs/SPEC.md describes every byte.
 */
#ifndef HAPTABLE_FRAME_BODY_H
#define HAPTABLE_FRAME_BODY_H

#include "haptable_body.h"
#include "haptable_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTABLE_FRAME_POSE 8 /* from the servo: f32 position_m[3], turn[4], velocity[3], spin[3], on_floor u32 */
#define HAPTABLE_FRAME_POSE_PAYLOAD 56
#define HAPTABLE_FRAME_POSE_BYTES (12 + HAPTABLE_FRAME_POSE_PAYLOAD)

/* The longest answer: where the body is, and a force. */
#define HAPTABLE_FRAME_BODY_BYTES (HAPTABLE_FRAME_POSE_BYTES + HAPTABLE_FRAME_BYTES)

/* Writes a whole frame to bytes: where the body is and how it moves. Returns its length. */
uint32_t haptable_frame_write_pose(uint32_t sequence, const struct haptable_body_state* body,
                                   uint8_t bytes[HAPTABLE_FRAME_POSE_BYTES]);

/* 1 when the frame is a pose; then position, turn, velocity, spin and on_floor of body hold it. */
int haptable_frame_take_pose(const struct haptable_frame* frame, struct haptable_body_state* body);

/* The servo's end of a line. The caller owns it; haptable_frame_body_init makes it valid. */
struct haptable_frame_body {
    struct haptable_servo servo;
    struct haptable_output out; /* of the last tick */
    struct haptable_body_state body;
    struct haptable_frame_reader reader;
    uint32_t sequence;                       /* of that tick */
    uint32_t time_us;                        /* the same */
    uint8_t is_stepped;                      /* 0: there was none yet */
    uint8_t pose[HAPTABLE_FRAME_POSE_BYTES]; /* its frame: where the body was, whose frame the contact is in */
};

/* No tick, no contact, the tables checked, the body where it is made. */
void haptable_frame_body_init(const struct haptable_model* model, const struct haptable_body* body,
                              struct haptable_frame_body* line);

/* Takes one byte. Returns how many bytes of an answer are to be sent: 0 but where it completes a state. One that comes
 * twice is answered twice and stepped once. Between ticks the caller goes on with haptable_check. cost:
 * haptable_frame_read's; with a state haptable_body_step's, and the CRCs of both frames. */
uint32_t haptable_frame_body_take(const struct haptable_model* model, const struct haptable_body* body,
                                  struct haptable_frame_body* line, uint8_t byte,
                                  uint8_t answer[HAPTABLE_FRAME_BODY_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
