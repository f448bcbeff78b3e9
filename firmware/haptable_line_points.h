/* SPDX-License-Identifier: MIT
 *
 * The serial line of three fingers and more, and of a tool: haptable_line.h, with other ticks
 *
 * A board calls haptable_hands_line or haptable_tool_line in place of haptable_line. Hands have the states and answers
 * of two fingers, with more of them; a tool has frames of its own types, with pose and wrench. Hellos are the same.
 */
#ifndef HAPTABLE_LINE_POINTS_H
#define HAPTABLE_LINE_POINTS_H

#include "haptable_line.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Frame types. */
#define HAPTABLE_LINE_TOOL_STATE 13  /* to the servo: struct haptable_tool_line_state */
#define HAPTABLE_LINE_TOOL_ANSWER 14 /* from the servo: struct haptable_tool_line_answer */

/* Bytes, as in haptable.h. An answer of a tool has those of its points that are inside. */
#define HAPTABLE_HANDS_LINE_STATE_BYTES HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_LINE_STATE_PAYLOAD(HAPTABLE_HANDS))
#define HAPTABLE_HANDS_LINE_ANSWER_BYTES HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_LINE_ANSWER_PAYLOAD(HAPTABLE_HANDS, 0, 0))
#define HAPTABLE_TOOL_LINE_STATE_PAYLOAD (HAPTABLE_LINE_STATE_PAYLOAD(1) + 16)
#define HAPTABLE_TOOL_LINE_STATE_BYTES HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_TOOL_LINE_STATE_PAYLOAD)
#define HAPTABLE_TOOL_LINE_ANSWER_PAYLOAD(inside) (128 + 38 * (inside))
#define HAPTABLE_TOOL_LINE_ANSWER_BYTES HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_TOOL_LINE_ANSWER_PAYLOAD(HAPTABLE_POINTS))

/* Input and output of a tick of three fingers and more. */
struct haptable_hands_line_state {
    uint32_t time_us; /* wraps */
    uint8_t begins;   /* a bit for each finger that is reset and loses its contact */
    struct haptable_input in[HAPTABLE_HANDS];
};

struct haptable_hands_line_answer {
    struct haptable_output out[HAPTABLE_HANDS]; /* without `patch` */
};

/* The same of a tool. */
struct haptable_tool_line_state {
    uint32_t time_us; /* wraps */
    uint8_t begins;   /* 1: the tool is reset and loses its contacts */
    struct haptable_tool_input in;
};

/* A point of a tool that is inside. */
struct haptable_line_point {
    uint16_t patch;
    float alpha[3];
    float god_object_m[3];
    float load_n[3]; /* on the body */
};

struct haptable_tool_line_answer {
    struct haptable_tool_output out; /* without `patch` */
    float stored_j;                  /* by all points */
    uint32_t inside;                 /* a bit for each point that is */
    struct haptable_line_point point[HAPTABLE_POINTS];
};

/* ---- the servo's end: as haptable_line_end, haptable_line_begin, haptable_line in haptable.h -----------------------
 */

struct haptable_points_line {
    struct haptable_line_reader reader;
    struct haptable_line_hello own; /* the scene's */
    uint32_t sequence;              /* of the last tick */
    uint32_t time_us;               /* the same */
    uint16_t length;                /* of its answer; 0: there was no tick yet */
    uint8_t is_other;               /* 1: the host is of another version */
    uint8_t hello[HAPTABLE_LINE_HELLO_BYTES];
};

struct haptable_hands_line_end {
    struct haptable_points_line line;
    uint8_t in[HAPTABLE_HANDS_LINE_STATE_BYTES];
    uint8_t answer[HAPTABLE_HANDS_LINE_ANSWER_BYTES];
};

struct haptable_tool_line_end {
    struct haptable_points_line line;
    uint8_t in[HAPTABLE_TOOL_LINE_STATE_BYTES];
    uint8_t answer[HAPTABLE_TOOL_LINE_ANSWER_BYTES];
};

/* before: the scene has three fingers and more; a tool. */
const uint8_t* haptable_hands_line_begin(const struct haptable_scene* scene, struct haptable_hands_line_end* line,
                                         uint32_t* count);
const uint8_t* haptable_hands_line(const struct haptable_scene* scene, void* state,
                                   struct haptable_hands_line_end* line, uint8_t byte, uint32_t* count);
const uint8_t* haptable_tool_line_begin(const struct haptable_scene* scene, struct haptable_tool_line_end* line,
                                        uint32_t* count);
const uint8_t* haptable_tool_line(const struct haptable_scene* scene, void* state, struct haptable_tool_line_end* line,
                                  uint8_t byte, uint32_t* count);

/* ---- both ends, and the host's: as in haptable_line.h --------------------------------------------------------------
 */

/* Of a scene with a tool; of hands haptable_line_describe. */
void haptable_tool_line_describe(const struct haptable_scene* scene, struct haptable_line_hello* hello);

int haptable_hands_line_take_state(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                                   struct haptable_hands_line_state* state);
int haptable_hands_line_take_answer(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                                    struct haptable_hands_line_answer* answer);
int haptable_tool_line_take_state(const struct haptable_line_frame* frame, struct haptable_tool_line_state* state);
int haptable_tool_line_take_answer(const struct haptable_line_frame* frame, struct haptable_tool_line_answer* answer);

/* What is sent is not changed. */
uint32_t haptable_hands_line_write_state(uint32_t sequence, const struct haptable_line_hello* hello,
                                         struct haptable_hands_line_state* state,
                                         uint8_t bytes[HAPTABLE_HANDS_LINE_STATE_BYTES]);
uint32_t haptable_hands_line_write_answer(uint32_t sequence, const struct haptable_line_hello* hello,
                                          struct haptable_hands_line_answer* answer,
                                          uint8_t bytes[HAPTABLE_HANDS_LINE_ANSWER_BYTES]);
uint32_t haptable_tool_line_write_state(uint32_t sequence, struct haptable_tool_line_state* state,
                                        uint8_t bytes[HAPTABLE_TOOL_LINE_STATE_BYTES]);
uint32_t haptable_tool_line_write_answer(uint32_t sequence, struct haptable_tool_line_answer* answer,
                                         uint8_t bytes[HAPTABLE_TOOL_LINE_ANSWER_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
