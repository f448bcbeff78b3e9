/* SPDX-License-Identifier: MIT
 *
 * bytes -> frames -> state -> haptable_step -> answer -> bytes
 */
#include "haptable_line.h"

#include "haptable_line_walk.h"

/* ---- payloads -------------------------------------------------------------------------------------------------- */

static void walk_hello(struct walk* walk, struct haptable_line_hello* hello) {
    uint32_t low = (uint32_t)hello->hash;
    uint32_t high = (uint32_t)(hello->hash >> 32);
    walk_byte(walk, &hello->version);
    walk_byte(walk, &hello->fingers);
    walk_byte(walk, &hello->modes);
    walk_byte(walk, &hello->flags);
    walk_word(walk, &low);
    walk_word(walk, &high);
    hello->hash = low | ((uint64_t)high << 32);
}

static void walk_state(struct walk* walk, const struct haptable_line_hello* hello, struct haptable_line_state* state) {
    uint8_t there = 0;
    for (int f = 0; f < hello->fingers; ++f)
        if (state->in[f].is_there) there |= (uint8_t)(1u << f);
    walk_word(walk, &state->time_us);
    walk_byte(walk, &there);
    walk_byte(walk, &state->begins);
    for (int f = 0; f < hello->fingers; ++f) {
        state->in[f].is_there = (uint8_t)(there >> f & 1u);
        walk_floats(walk, state->in[f].finger_m, 3);
        walk_word(walk, &state->in[f].buttons);
    }
}

static void walk_pose(struct walk* walk, struct haptable_body_pose* pose) {
    walk_floats(walk, pose->position_m, 3);
    walk_floats(walk, pose->turn, 4);
    walk_floats(walk, pose->velocity_m_per_s, 3);
    walk_floats(walk, pose->spin_rad_per_s, 3);
    walk_byte(walk, &pose->on_floor);
}

static void walk_answer(struct walk* walk, const struct haptable_line_hello* hello,
                        struct haptable_line_answer* answer) {
    for (int f = 0; f < hello->fingers; ++f) walk_output(walk, &answer->out[f]);
    if ((hello->flags & HAPTABLE_LINE_FREE) != 0u) walk_pose(walk, &answer->pose);
    walk_floats(walk, answer->q, hello->modes);
}

/* ---- frames ---------------------------------------------------------------------------------------------------- */

static uint32_t word_at(uint8_t* bytes, uint32_t count) {
    struct walk walk = {bytes, 1};
    return walk_bits(&walk, 0, count);
}

uint32_t haptable_line_write_hello(uint32_t sequence, struct haptable_line_hello hello,
                                   uint8_t bytes[HAPTABLE_LINE_HELLO_BYTES]) {
    struct walk walk = begin_frame(HAPTABLE_LINE_HELLO, sequence, bytes);
    walk_hello(&walk, &hello);
    return end_frame(walk, bytes);
}

uint32_t haptable_line_write_state(uint32_t sequence, const struct haptable_line_hello* hello,
                                   struct haptable_line_state state, uint8_t bytes[HAPTABLE_LINE_STATE_BYTES]) {
    struct walk walk = begin_frame(HAPTABLE_LINE_STATE, sequence, bytes);
    walk_state(&walk, hello, &state);
    return end_frame(walk, bytes);
}

uint32_t haptable_line_write_answer(uint32_t sequence, const struct haptable_line_hello* hello,
                                    struct haptable_line_answer* answer, uint8_t bytes[HAPTABLE_LINE_ANSWER_BYTES]) {
    struct walk walk = begin_frame(HAPTABLE_LINE_ANSWER, sequence, bytes);
    walk_answer(&walk, hello, answer);
    return end_frame(walk, bytes);
}

int haptable_line_take_hello(const struct haptable_line_frame* frame, struct haptable_line_hello* hello) {
    static const struct haptable_line_hello none = {0};
    struct walk walk = {frame->payload, 1};
    if (frame->type != HAPTABLE_LINE_HELLO || frame->length == 0) return 0;
    *hello = none;
    if (frame->payload[0] != HAPTABLE_LINE_VERSION) {
        hello->version = frame->payload[0];
        return 1;
    }
    if (frame->length != HAPTABLE_LINE_HELLO_BYTES - HAPTABLE_LINE_HEAD - HAPTABLE_LINE_TAIL) return 0;
    walk_hello(&walk, hello);
    return 1;
}

int haptable_line_take_state(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                             struct haptable_line_state* state) {
    static const struct haptable_line_state none = {0};
    struct walk walk = {frame->payload, 1};
    if (frame->type != HAPTABLE_LINE_STATE || frame->length != HAPTABLE_LINE_STATE_PAYLOAD(hello->fingers)) return 0;
    *state = none;
    walk_state(&walk, hello, state);
    return 1;
}

int haptable_line_take_answer(const struct haptable_line_frame* frame, const struct haptable_line_hello* hello,
                              struct haptable_line_answer* answer) {
    static const struct haptable_line_answer none = {0};
    struct walk walk = {frame->payload, 1};
    const int is_free = (hello->flags & HAPTABLE_LINE_FREE) != 0u;
    if (frame->type != HAPTABLE_LINE_ANSWER) return 0;
    if (frame->length != HAPTABLE_LINE_ANSWER_PAYLOAD(hello->fingers, is_free, hello->modes)) return 0;
    *answer = none;
    walk_answer(&walk, hello, answer);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) answer->out[f].patch = HAPTABLE_NONE;
    return 1;
}

/* ---- reading --------------------------------------------------------------------------------------------------- */

void haptable_line_reader_init(uint8_t* byte, uint16_t room, struct haptable_line_reader* reader) {
    reader->byte = byte;
    reader->room = room;
    reader->count = 0;
    reader->frames = 0;
    reader->skipped_bytes = 0;
}

/* Forgets the first bytes: there are few, and this happens once a frame or once a byte of garbage. */
static void drop(struct haptable_line_reader* reader, uint32_t bytes) {
    reader->count = (uint16_t)(reader->count - bytes);
    for (uint32_t i = 0; i < reader->count; ++i) reader->byte[i] = reader->byte[i + bytes];
}

static uint32_t whole_frame(const struct haptable_line_reader* reader) {
    return HAPTABLE_LINE_HEAD + word_at(reader->byte + 2, 2) + HAPTABLE_LINE_TAIL;
}

/* What the bytes so far are: the begin of a frame (0), a whole frame (1), or neither (-1). */
static int judge(const struct haptable_line_reader* reader) {
    uint8_t* byte = reader->byte;
    if (reader->count > 0 && byte[0] != (HAPTABLE_LINE_SYNC & 0xFFu)) return -1;
    if (reader->count > 1 && byte[1] != HAPTABLE_LINE_SYNC >> 8) return -1;
    if (reader->count < 4) return 0;
    const uint32_t whole = whole_frame(reader);
    if (whole > reader->room) return -1;
    if (reader->count < whole) return 0;
    return crc_of(byte + 2, whole - 2u - HAPTABLE_LINE_TAIL) == word_at(byte + whole - HAPTABLE_LINE_TAIL, 4) ? 1 : -1;
}

int haptable_line_read(struct haptable_line_reader* reader, uint8_t byte, struct haptable_line_frame* frame) {
    int verdict;
    /* The frame that was handed out stands at the begin until now. */
    if (reader->count > 0 && judge(reader) == 1) drop(reader, whole_frame(reader));
    reader->byte[reader->count++] = byte;
    while ((verdict = judge(reader)) < 0) {
        ++reader->skipped_bytes;
        drop(reader, 1);
    }
    if (verdict == 0) return 0;
    ++reader->frames;
    frame->length = (uint16_t)word_at(reader->byte + 2, 2);
    frame->type = reader->byte[4];
    frame->sequence = word_at(reader->byte + 5, 4);
    frame->payload = reader->byte + HAPTABLE_LINE_HEAD;
    return 1;
}

/* ---- the servo's end ------------------------------------------------------------------------------------------- */

void haptable_line_describe(const struct haptable_scene* scene, struct haptable_line_hello* hello) {
    hello->version = HAPTABLE_LINE_VERSION;
    hello->fingers = (uint8_t)haptable_scene_fingers(scene);
    hello->modes = scene->modes ? scene->modes->count : 0u;
    hello->flags =
        (uint8_t)((scene->body ? HAPTABLE_LINE_FREE : 0) | (scene->model->ungrabbed ? HAPTABLE_LINE_GRABS : 0));
    hello->hash = scene->model->hash;
}

static const uint8_t* say_hello(const struct haptable_line_hello* own, uint32_t sequence,
                                struct haptable_line_end* line, uint32_t* count) {
    struct haptable_line_hello hello = *own;
    if (line->is_other) hello.flags |= (uint8_t)HAPTABLE_LINE_OTHER_VERSION;
    *count = haptable_line_write_hello(sequence, hello, line->hello);
    return line->hello;
}

const uint8_t* haptable_line_begin(const struct haptable_scene* scene, struct haptable_line_end* line,
                                   uint32_t* count) {
    struct haptable_line_hello own;
    haptable_line_describe(scene, &own);
    haptable_line_reader_init(line->in, (uint16_t)HAPTABLE_LINE_FRAME_BYTES(HAPTABLE_LINE_STATE_PAYLOAD(own.fingers)),
                              &line->reader);
    line->length = 0;
    line->is_other = 0;
    return say_hello(&own, 0, line, count);
}

static void copy(const float* from, float* to, int count) {
    for (int i = 0; i < count; ++i) to[i] = from[i];
}

/* A gap in time drops the contacts, as silence does. */
static void tick(const struct haptable_scene* scene, void* servos, const struct haptable_line_state* state,
                 struct haptable_line_answer* answer) {
    for (int f = 0; f < haptable_scene_fingers(scene); ++f) {
        struct haptable_servo* servo = haptable_scene_servo(servos, f);
        if ((state->begins >> f & 1u) != 0u)
            (void)haptable_servo_watch(servo, servo->position_us + HAPTABLE_SILENCE_US, &answer->out[f]);
    }
    if (scene->body) haptable_pose_of(scene, servos, &answer->pose);
    haptable_step(scene, servos, state->in, state->time_us, answer->out);
    if (scene->modes) copy(haptable_swing_of(scene, servos), answer->q, scene->modes->count);
}

const uint8_t* haptable_line(const struct haptable_scene* scene, void* state, struct haptable_line_end* line,
                             uint8_t byte, uint32_t* count) {
    struct haptable_line_frame frame;
    struct haptable_line_hello own, host;
    struct haptable_line_state fingers;
    *count = 0;
    if (!haptable_line_read(&line->reader, byte, &frame)) return 0;
    haptable_line_describe(scene, &own);
    if (haptable_line_take_hello(&frame, &host)) {
        line->is_other = host.version != HAPTABLE_LINE_VERSION;
        return say_hello(&own, frame.sequence, line, count);
    }
    if (line->is_other || !haptable_line_take_state(&frame, &own, &fingers)) return 0;
    if (line->length == 0 || frame.sequence != line->sequence || fingers.time_us != line->time_us) {
        struct haptable_line_answer answer;
        tick(scene, state, &fingers, &answer);
        line->sequence = frame.sequence;
        line->time_us = fingers.time_us;
        line->length = (uint16_t)haptable_line_write_answer(frame.sequence, &own, &answer, line->answer);
    }
    *count = line->length;
    return line->answer;
}
