/* SPDX-License-Identifier: MIT
 *
 * A body that nothing holds under two fingers on a serial line: the frames of haptable_frame_pair.h, and before the
 * forces of each tick where the body is in it.
 */
#ifndef HAPTABLE_FRAME_BODY_PAIR_H
#define HAPTABLE_FRAME_BODY_PAIR_H

#include "haptable_body_pair.h"
#include "haptable_frame_body.h"
#include "haptable_frame_pair.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The longest answer: where the body is, and two forces. */
#define HAPTABLE_FRAME_BODY_PAIR_BYTES (HAPTABLE_FRAME_POSE_BYTES + HAPTABLE_FRAME_PAIR_BYTES)

/* The servo's end of a line. The caller owns it; haptable_frame_body_pair_init makes it valid. */
struct haptable_frame_body_pair {
    struct haptable_frame_pair fingers;
    struct haptable_body_state body;
    uint8_t pose[HAPTABLE_FRAME_POSE_BYTES]; /* the last tick's frame */
};

/* No tick, no contact, the tables checked, the body where it is made. */
void haptable_frame_body_pair_init(const struct haptable_pair_model* tables, const struct haptable_body* body,
                                   struct haptable_frame_body_pair* line);

/* As haptable_frame_pair_take; with a tick haptable_body_pair_step, or haptable_body_step_finger of one. */
uint32_t haptable_frame_body_pair_take(const struct haptable_pair_model* tables, const struct haptable_body* body,
                                       struct haptable_frame_body_pair* line, uint8_t byte,
                                       uint8_t answer[HAPTABLE_FRAME_BODY_PAIR_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
