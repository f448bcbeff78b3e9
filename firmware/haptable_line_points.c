/* SPDX-License-Identifier: MIT
 *
 * bytes -> frames -> state of hands or of a tool -> haptable_step -> answer -> bytes
 */
#include "haptable_line_points.h"

#include "haptable_line_walk.h"
#include "haptable_tool.h"

/* ---- payloads -------------------------------------------------------------------------------------------------- */

/* What every state begins with; then the fingers. As haptable_line.c has it: shared, it would take 50 bytes of every
 * image with one finger. */
static void walk_fingers(struct walk* walk, int fingers, uint32_t* time_us, uint8_t* begins,
                         struct haptable_input in[]) {
    uint8_t there = 0;
    for (int f = 0; f < fingers; ++f)
        if (in[f].is_there) there |= (uint8_t)(1u << f);
    walk_word(walk, time_us);
    walk_byte(walk, &there);
    walk_byte(walk, begins);
    for (int f = 0; f < fingers; ++f) {
        in[f].is_there = (uint8_t)(there >> f & 1u);
        walk_floats(walk, in[f].finger_m, 3);
        walk_word(walk, &in[f].buttons);
    }
}

static void walk_hands(struct walk* walk, int fingers, struct haptable_hands_line_answer* answer) {
    for (int f = 0; f < fingers; ++f) walk_output(walk, &answer->out[f]);
}

static void walk_tool_state(struct walk* walk, struct haptable_tool_line_state* state) {
    walk_fingers(walk, 1, &state->time_us, &state->begins, &state->in.hand);
    walk_floats(walk, state->in.turn, 4);
}

static void walk_point(struct walk* walk, struct haptable_line_point* point) {
    walk_half(walk, &point->patch);
    walk_floats(walk, point->alpha, 3);
    walk_floats(walk, point->god_object_m, 3);
    walk_floats(walk, point->load_n, 3);
}

/* What every answer of a tool has. */
static void walk_tool(struct walk* walk, struct haptable_tool_line_answer* answer) {
    walk_output(walk, &answer->out.hand);
    walk_floats(walk, answer->out.torque_n_m, 3);
    walk_floats(walk, answer->out.position_m, 3);
    walk_floats(walk, answer->out.turn, 4);
    walk_floats(walk, &answer->stored_j, 1);
    walk_word(walk, &answer->inside);
}

static void walk_points(struct walk* walk, struct haptable_tool_line_answer* answer) {
    for (uint32_t i = 0; i < HAPTABLE_POINTS; ++i)
        if ((answer->inside >> i & 1u) != 0u) walk_point(walk, &answer->point[i]);
}

/* ---- frames ---------------------------------------------------------------------------------------------------- */

uint32_t haptable_hands_line_write_state(uint32_t sequence, const struct haptable_line_hello* hello,
                                         struct haptable_hands_line_state* state,
                                         uint8_t bytes[HAPTABLE_HANDS_LINE_STATE_BYTES]) {
    struct walk walk = begin_frame(HAPTABLE_LINE_STATE, sequence, bytes);
    walk_fingers(&walk, hello->fingers, &state->time_us, &state->begins, state->in);
    return end_frame(walk, bytes);
}

uint32_t haptable_hands_line_write_answer(uint32_t sequence, const struct haptable_line_hello* hello,
                                          struct haptable_hands_line_answer* answer,
                                          uint8_t bytes[HAPTABLE_HANDS_LINE_ANSWER_BYTES]) {
    struct walk walk = begin_frame(HAPTABLE_LINE_ANSWER, sequence, bytes);
    walk_hands(&walk, hello->fingers, answer);
    return end_frame(walk, bytes);
}

uint32_t haptable_tool_line_write_state(uint32_t sequence, struct haptable_tool_line_state* state,
                                        uint8_t bytes[HAPTABLE_TOOL_LINE_STATE_BYTES]) {
    struct walk walk = begin_frame(HAPTABLE_LINE_TOOL_STATE, sequence, bytes);
    walk_tool_state(&walk, state);
    return end_frame(walk, bytes);
}

uint32_t haptable_tool_line_write_answer(uint32_t sequence, struct haptable_tool_line_answer* answer,
                                         uint8_t bytes[HAPTABLE_TOOL_LINE_ANSWER_BYTES]) {
    struct walk walk = begin_frame(HAPTABLE_LINE_TOOL_ANSWER, sequence, bytes);
    walk_tool(&walk, answer);
    walk_points(&walk, answer);
    return end_frame(walk, bytes);
}

int haptable_hands_line_take_state(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                                   struct haptable_hands_line_state* state) {
    static const struct haptable_hands_line_state none = {0};
    struct walk walk = {frame->payload, 1};
    if (frame->type != HAPTABLE_LINE_STATE || frame->length != HAPTABLE_LINE_STATE_PAYLOAD(hello->fingers)) return 0;
    *state = none;
    walk_fingers(&walk, hello->fingers, &state->time_us, &state->begins, state->in);
    return 1;
}

int haptable_hands_line_take_answer(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                                    struct haptable_hands_line_answer* answer) {
    static const struct haptable_hands_line_answer none = {0};
    struct walk walk = {frame->payload, 1};
    if (frame->type != HAPTABLE_LINE_ANSWER) return 0;
    if (frame->length != HAPTABLE_LINE_ANSWER_PAYLOAD(hello->fingers, 0, 0)) return 0;
    *answer = none;
    walk_hands(&walk, hello->fingers, answer);
    for (int f = 0; f < HAPTABLE_HANDS; ++f) answer->out[f].patch = HAPTABLE_NONE;
    return 1;
}

int haptable_tool_line_take_state(const struct haptable_line_frame* frame, struct haptable_tool_line_state* state) {
    static const struct haptable_tool_line_state none = {0};
    struct walk walk = {frame->payload, 1};
    if (frame->type != HAPTABLE_LINE_TOOL_STATE || frame->length != HAPTABLE_TOOL_LINE_STATE_PAYLOAD) return 0;
    *state = none;
    walk_tool_state(&walk, state);
    return 1;
}

static uint32_t bits_of(uint32_t word) {
    uint32_t count = 0;
    for (; word != 0u; word &= word - 1u) ++count;
    return count;
}

int haptable_tool_line_take_answer(const struct haptable_line_frame* frame, struct haptable_tool_line_answer* answer) {
    static const struct haptable_tool_line_answer none = {0};
    struct walk walk = {frame->payload, 1};
    if (frame->type != HAPTABLE_LINE_TOOL_ANSWER || frame->length < HAPTABLE_TOOL_LINE_ANSWER_PAYLOAD(0)) return 0;
    *answer = none;
    walk_tool(&walk, answer);
    if (frame->length != HAPTABLE_TOOL_LINE_ANSWER_PAYLOAD(bits_of(answer->inside))) return 0;
    walk_points(&walk, answer);
    answer->out.hand.patch = HAPTABLE_NONE;
    return 1;
}

/* ---- what the servo's ends share --------------------------------------------------------------------------------- */

static const uint8_t* say_hello(struct haptable_points_line* line, uint32_t sequence, uint32_t* count) {
    struct haptable_line_hello hello = line->own;
    if (line->is_other) hello.flags |= (uint8_t)HAPTABLE_LINE_OTHER_VERSION;
    *count = haptable_line_write_hello(sequence, hello, line->hello);
    return line->hello;
}

/* before: `own` is described. */
static const uint8_t* begin_line(struct haptable_points_line* line, uint8_t* in, uint16_t room, uint32_t* count) {
    haptable_line_reader_init(in, room, &line->reader);
    line->length = 0;
    line->is_other = 0;
    return say_hello(line, 0, count);
}

static int hears_hello(struct haptable_points_line* line, const struct haptable_line_frame* frame) {
    struct haptable_line_hello host;
    if (!haptable_line_take_hello(frame, &host)) return 0;
    line->is_other = host.version != HAPTABLE_LINE_VERSION;
    return 1;
}

/* 0: the last tick is asked for again. */
static int is_new(struct haptable_points_line* line, uint32_t sequence, uint32_t time_us) {
    if (line->length != 0 && sequence == line->sequence && time_us == line->time_us) return 0;
    line->sequence = sequence;
    line->time_us = time_us;
    return 1;
}

/* ---- hands ------------------------------------------------------------------------------------------------------- */

const uint8_t* haptable_hands_line_begin(const struct haptable_scene* scene, struct haptable_hands_line_end* line,
                                         uint32_t* count) {
    haptable_line_describe(scene, &line->line.own);
    return begin_line(&line->line, line->in,
                      (uint16_t)HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_LINE_STATE_PAYLOAD(line->line.own.fingers)), count);
}

static void tick_hands(const struct haptable_scene* scene, void* state, const struct haptable_hands_line_state* in,
                       struct haptable_hands_line_end* line) {
    struct haptable_hands_line_answer answer;
    for (int f = 0; f < line->line.own.fingers; ++f) {
        struct haptable_servo* servo = haptable_scene_servo(state, f);
        if ((in->begins >> f & 1u) != 0u)
            (void)haptable_servo_watch(servo, servo->position_us + HAPTABLE_SILENCE_US, &answer.out[f]);
    }
    haptable_step(scene, state, in->in, in->time_us, answer.out);
    line->line.length =
        (uint16_t)haptable_hands_line_write_answer(line->line.sequence, &line->line.own, &answer, line->answer);
}

const uint8_t* haptable_hands_line(const struct haptable_scene* scene, void* state,
                                   struct haptable_hands_line_end* line, uint8_t byte, uint32_t* count) {
    struct haptable_line_frame frame;
    struct haptable_hands_line_state in;
    *count = 0;
    if (!haptable_line_read(&line->line.reader, byte, &frame)) return 0;
    if (hears_hello(&line->line, &frame)) return say_hello(&line->line, frame.sequence, count);
    if (line->line.is_other || !haptable_hands_line_take_state(&frame, &line->line.own, &in)) return 0;
    if (is_new(&line->line, frame.sequence, in.time_us)) tick_hands(scene, state, &in, line);
    *count = line->line.length;
    return line->answer;
}

/* ---- a tool ------------------------------------------------------------------------------------------------------ */

void haptable_tool_line_describe(const struct haptable_scene* scene, struct haptable_line_hello* hello) {
    haptable_line_describe(scene, hello);
    hello->flags |= (uint8_t)HAPTABLE_LINE_TOOL;
}

const uint8_t* haptable_tool_line_begin(const struct haptable_scene* scene, struct haptable_tool_line_end* line,
                                        uint32_t* count) {
    haptable_tool_line_describe(scene, &line->line.own);
    return begin_line(&line->line, line->in, (uint16_t)HAPTABLE_TOOL_LINE_STATE_BYTES, count);
}

/* Those that are inside, and what all store. */
static void put_points(const struct haptable_points_model* points, void* state,
                       struct haptable_tool_line_answer* answer) {
    answer->stored_j = haptable_points_of(points, state)->energy_j;
    answer->inside = 0;
    for (uint32_t i = 0; i < points->count; ++i) {
        const struct haptable_point* from = &haptable_points_in(points, state)[i];
        struct haptable_line_point* to = &answer->point[i];
        if (!from->is_inside) continue;
        answer->inside |= 1u << i;
        to->patch = from->at.patch;
        for (int axis = 0; axis < 3; ++axis) {
            to->alpha[axis] = from->at.alpha[axis];
            to->god_object_m[axis] = from->at.god_object_m[axis];
            to->load_n[axis] = from->load_n[axis];
        }
    }
}

static void tick_tool(const struct haptable_scene* scene, void* state, const struct haptable_tool_line_state* in,
                      struct haptable_tool_line_end* line) {
    struct haptable_tool_line_answer answer;
    if ((in->begins & 1u) != 0u)
        (void)haptable_tool_watch(scene, state, haptable_scene_servo(state, 0)->position_us + HAPTABLE_SILENCE_US,
                                  &answer.out);
    haptable_step(scene, state, &in->in.hand, in->time_us, &answer.out.hand);
    put_points(&haptable_tool_of(scene)->points, state, &answer);
    line->line.length = (uint16_t)haptable_tool_line_write_answer(line->line.sequence, &answer, line->answer);
}

const uint8_t* haptable_tool_line(const struct haptable_scene* scene, void* state, struct haptable_tool_line_end* line,
                                  uint8_t byte, uint32_t* count) {
    struct haptable_line_frame frame;
    struct haptable_tool_line_state in;
    *count = 0;
    if (!haptable_line_read(&line->line.reader, byte, &frame)) return 0;
    if (hears_hello(&line->line, &frame)) return say_hello(&line->line, frame.sequence, count);
    if (line->line.is_other || !haptable_tool_line_take_state(&frame, &in)) return 0;
    if (is_new(&line->line, frame.sequence, in.time_us)) tick_tool(scene, state, &in, line);
    *count = line->line.length;
    return line->answer;
}
