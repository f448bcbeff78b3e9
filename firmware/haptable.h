/* SPDX-License-Identifier: MIT
 *
 * haptable's servo on a board: a soft object that one finger or two can touch at 1 kHz
 *
 * A program (tests/firmware/header_test.cpp compiles and runs it as it stands):
 *
 *     #include "haptable.h"
 *     #include "model.h"
 *
 *     int device_read(int finger, float finger_m[3]);
 *     void device_write(int finger, const float force_n[3]);
 *     int device_wait(uint32_t* now_us);
 *
 *     static HAPTABLE_MODEL_STATE state;
 *     static struct haptable_input in[HAPTABLE_MODEL_FINGERS];
 *     static struct haptable_output out[HAPTABLE_MODEL_FINGERS];
 *
 *     int main(void) {
 *         uint32_t now_us;
 *         int finger;
 *         haptable_init(&HAPTABLE_MODEL_SCENE, &state);
 *         haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
 *         while (device_wait(&now_us)) {
 *             for (finger = 0; finger < HAPTABLE_MODEL_FINGERS; ++finger)
 *                 in[finger].is_there = (uint8_t)device_read(finger, in[finger].finger_m);
 *             haptable_step(&HAPTABLE_MODEL_SCENE, &state, in, now_us, out);
 *             for (finger = 0; finger < HAPTABLE_MODEL_FINGERS; ++finger) device_write(finger, out[finger].force_n);
 *             haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_BYTES);
 *         }
 *         return 0;
 *     }
 *
 * codegen writes model.h and model.c: the scene, const, so that it stays in flash, and a type for its state, of the
 * size that the scene needs. The caller owns the state; there is no other: any number of them run side by side on one
 * scene. A step never fails, it degrades: a bad position gives zero force and is counted by name.
 *
 * This is all that a board's program calls; haptable_types.h has what it gives and takes. Lengths are m, forces N,
 * times us; world coordinates are the scene's.
 */
#ifndef HAPTABLE_H
#define HAPTABLE_H

#include "haptable_types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Tables and servo trust each other only through this number: codegen writes it, model.h checks it. */
#define HAPTABLE_TABLE_VERSION 13

/* For haptable_check: all of the tables; and what fits beside a tick. */
#define HAPTABLE_CHECK_ALL 0xFFFFFFFFu
#define HAPTABLE_CHECK_BYTES 64u

/* ---- a tick ---------------------------------------------------------------------------------------------------- */

/* Fingers that are not known, a body that rests where it was made. before: state has scene->bytes, aligned as a
 * pointer. */
void haptable_init(const struct haptable_scene* scene, void* state);

/* One tick: fingers in, forces out, in world coordinates and axes; all else of out[] is in the body's frame of that
 * tick. in, out: of each finger of the scene. A gap of HAPTABLE_SILENCE_US, and a finger that is not there, drop its
 * contact. now_us may wrap. Bounded work; see SPEC.md. */
void haptable_step(const struct haptable_scene* scene, void* state, const struct haptable_input in[], uint32_t now_us,
                   struct haptable_output out[]);

/* To be called when no position has come: after HAPTABLE_SILENCE_US a finger's output is zero force and its contact is
 * dropped. Returns the bits of the fingers that are silent, whose out was written; 0: all are in time still. */
unsigned haptable_watch(const struct haptable_scene* scene, void* state, uint32_t now_us, struct haptable_output out[]);

/* The same of a tool, whose torque becomes zero with its force. before: the scene has a tool. */
unsigned haptable_tool_watch(const struct haptable_scene* scene, void* state, uint32_t now_us,
                             struct haptable_tool_output* out);

/* Goes on with the check of the scene's tables, of all its parts, by so many bytes, at most once through all of them;
 * then the next call begins anew. A model with a check gives no force before they were once found well: call it with
 * HAPTABLE_CHECK_ALL before the first tick, and with HAPTABLE_CHECK_BYTES whenever there is time. Tables that are
 * damaged are HAPTABLE_FAULT_TABLES of every finger. cost: see docs/SAFETY.md */
void haptable_check(const struct haptable_scene* scene, void* state, uint32_t bytes);

/* What was counted of a finger. */
const struct haptable_counters* haptable_counters_of(const void* state, int finger);

/* ---- what is drawn --------------------------------------------------------------------------------------------- */

/* Where the body is after the last tick. before: nothing holds the body ([body] free = true). */
void haptable_pose_of(const struct haptable_scene* scene, const void* state, struct haptable_body_pose* pose);

/* How far its modes have swung after the last tick, sqrt(kg) m: as many as [body] modes says. before: it has modes. */
const float* haptable_swing_of(const struct haptable_scene* scene, const void* state);

/* The displacements of the display's rows ([tables] display_rows) for the loads of one output; zero without contact.
 * after: displacement_m[0 .. row_count - 1] is written. cost: at most 3 columns of row_count blocks, 18 flops each. */
void haptable_deform(const struct haptable_deformation* deformation, const struct haptable_output* out,
                     float (*displacement_m)[3]);

/* ---- a serial line to the host --------------------------------------------------------------------------------- */

/* Bytes of whole frames: of every scene, and of the scene with the longest. */
#define HAPTABLE_LINE_FRAME_BYTES(payload) (13 + (payload))
#define HAPTABLE_LINE_HELLO_BYTES HAPTABLE_LINE_FRAME_BYTES(12)
#define HAPTABLE_LINE_STATE_PAYLOAD(fingers) (6 + 16 * (fingers))
#define HAPTABLE_LINE_STATE_BYTES HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_LINE_STATE_PAYLOAD(HAPTABLE_FINGERS))
#define HAPTABLE_LINE_ANSWER_PAYLOAD(fingers, is_free, modes) (80 * (fingers) + ((is_free) ? 53 : 0) + 4 * (modes))
#define HAPTABLE_LINE_ANSWER_BYTES \
    HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_LINE_ANSWER_PAYLOAD(HAPTABLE_FINGERS, 1, HAPTABLE_MODES))

/* The receiving end of a line. */
struct haptable_line_reader {
    uint8_t* byte;          /* what has come of a frame, and what came after a false begin */
    uint16_t room;          /* of it: the longest frame that is one */
    uint16_t count;         /* bytes in it */
    uint32_t frames;        /* whole ones */
    uint32_t skipped_bytes; /* that belonged to none */
};

/* The servo's end. The caller owns it; haptable_line_begin makes it valid. */
struct haptable_line_end {
    struct haptable_line_reader reader;
    uint32_t sequence; /* of the last tick */
    uint32_t time_us;  /* the same */
    uint16_t length;   /* of its answer; 0: there was no tick yet */
    uint8_t is_other;  /* 1: the host is of another version */
    uint8_t in[HAPTABLE_LINE_STATE_BYTES];
    uint8_t hello[HAPTABLE_LINE_HELLO_BYTES];
    uint8_t answer[HAPTABLE_LINE_ANSWER_BYTES];
};

/* Begins a line that knows no tick. Returns the target's hello, *count bytes to be sent: a host that was there before
 * learns that the target began anew. */
const uint8_t* haptable_line_begin(const struct haptable_scene* scene, struct haptable_line_end* line, uint32_t* count);

/* Takes one byte. Returns the bytes to be sent, *count of them, which are there until the next call; NULL and 0 but
 * where the byte completes a hello or a state. A state with sequence and time of the last one is answered again and not
 * stepped. Between ticks the caller goes on with haptable_check. cost: haptable_line_read's; with a state
 * haptable_step's, and the CRC of the answer. */
const uint8_t* haptable_line(const struct haptable_scene* scene, void* state, struct haptable_line_end* line,
                             uint8_t byte, uint32_t* count);

#ifdef __cplusplus
}
#endif

#endif
