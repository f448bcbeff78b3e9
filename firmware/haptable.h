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
 * This is all that a board's program calls. Lengths are m, forces N, times us; world coordinates are the scene's.
 */
#ifndef HAPTABLE_H
#define HAPTABLE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Tables and servo trust each other only through this number: codegen writes it, model.h checks it. */
#define HAPTABLE_TABLE_VERSION 13

/* No patch, no neighbour. A model has at most 65,534 patches and as many vertices. */
#define HAPTABLE_NONE 0xFFFFu

/* The most fingers on any body, and on one that is held, follows at once and has a compliance; the most modes of a body
 * that rings; the most points of a tool. */
#define HAPTABLE_FINGERS 2
#define HAPTABLE_HANDS 8
#define HAPTABLE_MODES 16
#define HAPTABLE_POINTS 32

/* A tick, microseconds: the servo is called so often. */
#define HAPTABLE_TICK_US 1000u

/* No position for this long (microseconds): the force goes to zero. */
#define HAPTABLE_SILENCE_US 20000u

/* For haptable_check: all of the tables; and what fits beside a tick. */
#define HAPTABLE_CHECK_ALL 0xFFFFFFFFu
#define HAPTABLE_CHECK_BYTES 64u

enum haptable_state {
    HAPTABLE_SILENT = 0,   /* no position yet, or none for HAPTABLE_SILENCE_US: zero force */
    HAPTABLE_FREE = 1,     /* finger outside: zero force */
    HAPTABLE_CONTACT = 2,  /* god-object on the surface */
    HAPTABLE_REJECTED = 3, /* the last position was not one, or is not believed yet: zero force, contact dropped */
    HAPTABLE_LIMITED = 4,  /* contact, with less force than the body's: gain < 1 */
    HAPTABLE_FAULTED = 5   /* a fault that waits to be acknowledged, or tables that were not checked: zero force */
};

/* 1 in the states with contact. */
static inline int haptable_touches(int state) { return state == HAPTABLE_CONTACT || state == HAPTABLE_LIMITED; }

/* Why a servo is HAPTABLE_FAULTED: bits. They stand until HAPTABLE_BUTTON_ACKNOWLEDGE is pressed. */
enum haptable_fault {
    HAPTABLE_FAULT_TABLES = 1,   /* the tables' CRC is wrong, or was not taken yet: this one ends by the next check */
    HAPTABLE_FAULT_FORCE = 2,    /* a force was not a number */
    HAPTABLE_FAULT_POSITIONS = 4 /* implausible positions came again and again */
};

/* What a hand may hold down: bits of haptable_input.buttons. */
enum haptable_button {
    HAPTABLE_BUTTON_CLUTCH = 1,     /* the host's: the finger moves without the device's position */
    HAPTABLE_BUTTON_GRAB = 2,       /* the contact holds the finger */
    HAPTABLE_BUTTON_ACKNOWLEDGE = 4 /* a fault that waits for the user is over */
};

/* What the servo counts, by name: one list drives the struct, the messages and the reports. */
#define HAPTABLE_COUNTERS(X)                                              \
    X(ticks)              /* calls of haptable_step */                    \
    X(contact_ticks)      /* of these, with contact */                    \
    X(contacts)           /* contacts begun */                            \
    X(rejected_positions) /* NaN, infinite or absurd finger positions */  \
    X(implausible)        /* positions that no finger reaches in time */  \
    X(rejected_forces)    /* forces that were not finite: zero given */   \
    X(limited_ticks)      /* contact_ticks with less than the body's */   \
    X(rate_limits)        /* of these, where the rise of the force was */ \
    X(mean_limits)        /* of these, where the mean force was */        \
    X(faulted)            /* faults that had to be acknowledged */        \
    X(grabbed_ticks)      /* contact_ticks in which the hand held on */   \
    X(clamped_forces)     /* forces cut to max_force_n */                 \
    X(walk_limits)        /* slides that met HAPTABLE_WALK_STEPS */       \
    X(slide_limits)       /* ticks that met HAPTABLE_SLIDES */            \
    X(box_limits)         /* ticks that met HAPTABLE_TICK_BOXES */        \
    X(given_up)           /* contacts let go as limits left them open */  \
    X(jumps)              /* with release: forces that it smoothed */     \
    X(silences)           /* times without a position for SILENCE_US */   \
    X(most_steps)         /* most steps of the walk in one tick */        \
    X(most_held_steps)    /* with friction: most steps of holding back */ \
    X(most_energies)      /* most steps of the energy in one tick */      \
    X(most_boxes)         /* most boxes that one tick visited */

struct haptable_counters {
#define HAPTABLE_COUNTER_FIELD(name) uint32_t name;
    HAPTABLE_COUNTERS(HAPTABLE_COUNTER_FIELD)
#undef HAPTABLE_COUNTER_FIELD
};

/* A finger in a tick. */
struct haptable_input {
    float finger_m[3]; /* world coordinates; not trusted */
    uint32_t buttons;  /* held down: bits of enum haptable_button */
    uint8_t is_there;  /* 0: it has no position in this tick, and no contact */
};

/* What one tick gives. */
struct haptable_output {
    uint8_t state;             /* enum haptable_state */
    uint8_t faults;            /* enum haptable_fault; 0 but in HAPTABLE_FAULTED, HAPTABLE_SILENT */
    uint16_t patch;            /* HAPTABLE_NONE without contact */
    uint16_t vertex[3];        /* of that patch, or of a dent that recovers; HAPTABLE_NONE without either */
    float alpha[3];            /* 0 without either */
    float god_object_m[3];     /* the finger itself without contact; 0 when it was rejected */
    float nodal_force_n[3][3]; /* F_i on vertex[i] (eq. 10), not clamped: the load of the drawn deformation; where the
                                  body relaxes, that by which it would be so deformed at once; where its
                                  dents stiffen, that of the linear body */
    float force_n[3];          /* what the user feels (eq. 12), |force_n| <= max_force_n */
};

/* A tool of many points in a tick ([tool] in the scene). haptable_step takes &in.hand and &out.hand. */
struct haptable_tool_input {
    struct haptable_input hand; /* finger_m: where the handle is */
    float turn[4];              /* unit quaternion w x y z from the tool's axes to the world's; not trusted */
};

struct haptable_tool_output {
    struct haptable_output hand; /* force_n; else the contact of the point that presses most */
    float torque_n_m[3];         /* about the handle: what the user feels, |torque_n_m| <= max_torque_n_m */
    float position_m[3];         /* where the tool is drawn: at the hand, or as its virtual coupling has it */
    float turn[4];
};

/* What codegen writes; haptable_scene.h, haptable_deformation.h say what is in it. */
struct haptable_scene;
struct haptable_deformation;

/* Where a body is that nothing holds, and how it moves. */
struct haptable_body_pose {
    float position_m[3];
    float turn[4];
    float velocity_m_per_s[3];
    float spin_rad_per_s[3];
    uint8_t on_floor;
};

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
