/* SPDX-License-Identifier: MIT
 *
 * Two fingers on one serial line: frames of haptable_frame.h with types of their own, and what answers them.
 *
 *   bytes -> frames -> states of a tick -> haptable_pair_step, or haptable_step of one -> forces -> bytes
 *
 * Payloads are those of one finger's frames, and a line that has one finger is the same byte for byte. An entry of its
 * own: where no program calls it, nothing of it is linked. docs/SPEC.md describes every byte.
 */
#ifndef HAPTABLE_FRAME_PAIR_H
#define HAPTABLE_FRAME_PAIR_H

#include "haptable_frame.h"
#include "haptable_pair.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTABLE_FRAME_STATE_SECOND 3         /* of the second finger: a tick without the first */
#define HAPTABLE_FRAME_FORCE_SECOND 4         /* of the second finger */
#define HAPTABLE_FRAME_STATE_OF_BOTH 5        /* of the first finger: a tick of both, when the other's has come, too */
#define HAPTABLE_FRAME_STATE_SECOND_OF_BOTH 6 /* the same of the second finger */
#define HAPTABLE_FRAME_ASK 7 /* to the servo, no payload: the second finger's last force is asked for */

/* A bit of the buttons of a tick of both: this finger begins anew, without the contact that it had. */
#define HAPTABLE_FRAME_BEGINS 0x80000000u

/* The longest answer: two forces. */
#define HAPTABLE_FRAME_PAIR_BYTES (2 * HAPTABLE_FRAME_BYTES)

/* Write whole frames to bytes; return their length. finger: 0 or 1; of_both: 0 or 1, the tick has the other's state. */
uint32_t haptable_frame_write_state_of(int finger, int of_both, uint32_t sequence,
                                       const struct haptable_frame_state* state, uint8_t bytes[HAPTABLE_FRAME_BYTES]);
uint32_t haptable_frame_write_force_of(int finger, uint32_t sequence, uint64_t model_hash,
                                       const struct haptable_output* out, uint8_t bytes[HAPTABLE_FRAME_BYTES]);
uint32_t haptable_frame_write_ask(uint32_t sequence, uint8_t bytes[HAPTABLE_FRAME_BYTES]);

/* 1 when the frame is a state of either finger; then finger, of_both and state hold it. */
int haptable_frame_take_state_of(const struct haptable_frame* frame, int* finger, int* of_both,
                                 struct haptable_frame_state* state);

/* 1 when the frame is a force of either finger; then finger, model_hash and all of out but patch hold it. */
int haptable_frame_take_force_of(const struct haptable_frame* frame, int* finger, uint64_t* model_hash,
                                 struct haptable_output* out);

/* The servo's end of a line of two fingers. The caller owns it; haptable_frame_pair_init makes it valid. */
struct haptable_frame_pair {
    struct haptable_pair pair;
    struct haptable_output out[HAPTABLE_FINGERS]; /* of the last tick */
    struct haptable_frame_reader reader;
    struct haptable_frame_state state[HAPTABLE_FINGERS]; /* of the tick that was begun */
    uint32_t sequence;                                   /* of that tick */
    uint32_t time_us;                                    /* the same */
    uint8_t fingers;                                     /* a bit for each that is in it; 0: none was begun */
    uint8_t come;                                        /* of them, those whose state has come */
    uint8_t is_stepped;                                  /* 1: it is answered, and states of it are repeated ones */
    uint8_t is_asked;                                    /* 1: what is to be answered is a question */
    uint32_t asked;                                      /* its sequence */
};

/* No tick, no contact, the tables checked. */
void haptable_frame_pair_init(const struct haptable_pair_model* tables, struct haptable_frame_pair* line);

/* What a byte has completed: nothing; what is to be answered by haptable_frame_pair_write; and of that a tick that is
 * to be stepped before, line->state of those in line->fingers, who are not in it having been released. */
enum haptable_frame_pair_heard {
    HAPTABLE_FRAME_PAIR_NOTHING = 0,
    HAPTABLE_FRAME_PAIR_ANSWER = 1,
    HAPTABLE_FRAME_PAIR_TICK = 2
};

/* The two halves of haptable_frame_pair_take, for who steps the fingers otherwise. */
int haptable_frame_pair_hear(struct haptable_frame_pair* line, uint8_t byte);
uint32_t haptable_frame_pair_write(const struct haptable_pair_model* tables, const struct haptable_frame_pair* line,
                                   uint8_t answer[HAPTABLE_FRAME_PAIR_BYTES]);

/* Takes one byte. Returns how many bytes of an answer are to be sent: 0 but where it completes a tick, or a question.
 * States of a tick of both have one sequence and time and may come in either order; those of one that stays incomplete
 * are forgotten with the next. A tick that comes twice is answered twice and stepped once. Who is not in a tick is
 * released. Between ticks the caller goes on with haptable_pair_check. cost: haptable_frame_read's; with a tick
 * haptable_pair_step's, or one finger's, and four CRCs of a force. */
uint32_t haptable_frame_pair_take(const struct haptable_pair_model* tables, struct haptable_frame_pair* line,
                                  uint8_t byte, uint8_t answer[HAPTABLE_FRAME_PAIR_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
