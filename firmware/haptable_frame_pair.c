/* SPDX-License-Identifier: MIT
 *
 * See haptable_frame_pair.h.
 */
#include "haptable_frame_pair.h"

#include "haptable_crc.h"

#define HEAD 8u /* bytes before the payload */
#define TAIL 4u /* bytes after it */

#define FIRST 1u
#define SECOND 2u
#define BOTH 3u

static const uint8_t state_type[HAPTABLE_FINGERS][2] = {
    {HAPTABLE_FRAME_STATE, HAPTABLE_FRAME_STATE_OF_BOTH},
    {HAPTABLE_FRAME_STATE_SECOND, HAPTABLE_FRAME_STATE_SECOND_OF_BOTH}};
static const uint8_t force_type[HAPTABLE_FINGERS] = {HAPTABLE_FRAME_FORCE, HAPTABLE_FRAME_FORCE_SECOND};

/* ---- frames ---------------------------------------------------------------------------------------------------- */

/* A frame that was written, with another type and length. */
static uint32_t write_again(uint8_t type, uint8_t length, uint8_t* bytes) {
    const uint32_t before_crc = HEAD + length;
    uint32_t crc;
    uint32_t i;
    bytes[2] = length;
    bytes[3] = type;
    crc = ~haptable_crc(HAPTABLE_CRC_BEGIN, bytes + 2, before_crc - 2u);
    for (i = 0; i < TAIL; ++i) bytes[before_crc + i] = (uint8_t)(crc >> (8u * i));
    return before_crc + TAIL;
}

uint32_t haptable_frame_write_state_of(int finger, int of_both, uint32_t sequence,
                                       const struct haptable_frame_state* state, uint8_t bytes[HAPTABLE_FRAME_BYTES]) {
    (void)haptable_frame_write_state(sequence, state, bytes);
    return write_again(state_type[finger][of_both], HAPTABLE_FRAME_STATE_PAYLOAD, bytes);
}

uint32_t haptable_frame_write_force_of(int finger, uint32_t sequence, uint64_t model_hash,
                                       const struct haptable_output* out, uint8_t bytes[HAPTABLE_FRAME_BYTES]) {
    (void)haptable_frame_write_force(sequence, model_hash, out, bytes);
    return write_again(force_type[finger], HAPTABLE_FRAME_FORCE_PAYLOAD, bytes);
}

uint32_t haptable_frame_write_ask(uint32_t sequence, uint8_t bytes[HAPTABLE_FRAME_BYTES]) {
    static const struct haptable_frame_state none = {0, {0.0f, 0.0f, 0.0f}, 0};
    (void)haptable_frame_write_state(sequence, &none, bytes);
    return write_again(HAPTABLE_FRAME_ASK, 0, bytes);
}

int haptable_frame_take_state_of(const struct haptable_frame* frame, int* finger, int* of_both,
                                 struct haptable_frame_state* state) {
    struct haptable_frame as_first = *frame;
    int i;
    as_first.type = HAPTABLE_FRAME_STATE;
    for (i = 0; i < 2 * HAPTABLE_FINGERS; ++i) {
        *finger = i / 2;
        *of_both = i % 2;
        if (frame->type == state_type[*finger][*of_both]) return haptable_frame_take_state(&as_first, state);
    }
    return 0;
}

int haptable_frame_take_force_of(const struct haptable_frame* frame, int* finger, uint64_t* model_hash,
                                 struct haptable_output* out) {
    struct haptable_frame as_first = *frame;
    int i;
    as_first.type = HAPTABLE_FRAME_FORCE;
    for (i = 0; i < HAPTABLE_FINGERS; ++i) {
        *finger = i;
        if (frame->type == force_type[i]) return haptable_frame_take_force(&as_first, model_hash, out);
    }
    return 0;
}

/* ---- a tick ---------------------------------------------------------------------------------------------------- */

static int is_in(const struct haptable_frame_pair* line, int finger) {
    return (line->fingers & (finger == 0 ? FIRST : SECOND)) != 0u;
}

/* As after silence. */
static void release(struct haptable_frame_pair* line, int finger) {
    struct haptable_servo* servo = &line->pair.servo[finger];
    (void)haptable_watch(servo, servo->position_us + HAPTABLE_SILENCE_US, &line->out[finger]);
}

/* A gap in time drops the contact, as silence does. */
static void begin_finger(struct haptable_frame_pair* line, int finger) {
    struct haptable_servo* servo = &line->pair.servo[finger];
    uint32_t buttons = line->state[finger].buttons;
    if (line->fingers == BOTH) {
        if ((buttons & HAPTABLE_FRAME_BEGINS) != 0u) release(line, finger);
        buttons &= ~HAPTABLE_FRAME_BEGINS;
    }
    (void)haptable_watch(servo, line->time_us, &line->out[finger]);
    haptable_buttons(servo, buttons);
}

static void begin_tick(struct haptable_frame_pair* line) {
    int finger;
    for (finger = 0; finger < HAPTABLE_FINGERS; ++finger) {
        if (is_in(line, finger))
            begin_finger(line, finger);
        else
            release(line, finger);
    }
}

static void tick(const struct haptable_pair_model* tables, struct haptable_frame_pair* line) {
    const int one = line->fingers == FIRST ? 0 : 1;
    if (line->fingers == BOTH)
        haptable_pair_step(tables, &line->pair, line->state[0].position_m, line->state[1].position_m, line->time_us,
                           line->out);
    else
        haptable_step(tables->model, &line->pair.servo[one], line->state[one].position_m, line->time_us,
                      &line->out[one]);
}

/* ---- the line -------------------------------------------------------------------------------------------------- */

/* Takes a state into its tick, which begins with it where it is of another one. Returns 1 when the tick is complete. */
static int gather(struct haptable_frame_pair* line, const struct haptable_frame* frame) {
    struct haptable_frame_state state;
    uint8_t fingers;
    int finger;
    int of_both;
    if (!haptable_frame_take_state_of(frame, &finger, &of_both, &state)) return 0;
    fingers = (uint8_t)(of_both ? BOTH : (finger == 0 ? FIRST : SECOND));
    if (frame->sequence != line->sequence || state.time_us != line->time_us || fingers != line->fingers) {
        line->sequence = frame->sequence;
        line->time_us = state.time_us;
        line->fingers = fingers;
        line->come = 0;
        line->is_stepped = 0;
    }
    line->state[finger] = state;
    line->come = (uint8_t)(line->come | (finger == 0 ? FIRST : SECOND));
    return line->come == line->fingers;
}

void haptable_frame_pair_init(const struct haptable_pair_model* tables, struct haptable_frame_pair* line) {
    int finger;
    haptable_pair_init(tables, &line->pair);
    haptable_pair_check(tables, &line->pair, HAPTABLE_CHECK_ALL);
    for (finger = 0; finger < HAPTABLE_FINGERS; ++finger)
        (void)haptable_pair_watch(&line->pair, finger, 0, &line->out[finger]);
    haptable_frame_reader_init(&line->reader);
    line->sequence = 0;
    line->time_us = 0;
    line->fingers = 0;
    line->come = 0;
    line->is_stepped = 0;
    line->is_asked = 0;
    line->asked = 0;
}

int haptable_frame_pair_hear(struct haptable_frame_pair* line, uint8_t byte) {
    struct haptable_frame frame;
    if (!haptable_frame_read(&line->reader, byte, &frame)) return HAPTABLE_FRAME_PAIR_NOTHING;
    line->is_asked = frame.type == HAPTABLE_FRAME_ASK && frame.length == 0;
    line->asked = frame.sequence;
    if (line->is_asked) return HAPTABLE_FRAME_PAIR_ANSWER;
    if (!gather(line, &frame)) return HAPTABLE_FRAME_PAIR_NOTHING;
    line->come = 0;
    if (line->is_stepped) return HAPTABLE_FRAME_PAIR_ANSWER;
    line->is_stepped = 1;
    begin_tick(line);
    return HAPTABLE_FRAME_PAIR_TICK;
}

uint32_t haptable_frame_pair_write(const struct haptable_pair_model* tables, const struct haptable_frame_pair* line,
                                   uint8_t answer[HAPTABLE_FRAME_PAIR_BYTES]) {
    const uint64_t hash = tables->model->hash;
    uint32_t length = 0;
    int finger;
    if (line->is_asked) return haptable_frame_write_force_of(1, line->asked, hash, &line->out[1], answer);
    for (finger = 0; finger < HAPTABLE_FINGERS; ++finger)
        if (is_in(line, finger))
            length += haptable_frame_write_force_of(finger, line->sequence, hash, &line->out[finger], answer + length);
    return length;
}

uint32_t haptable_frame_pair_take(const struct haptable_pair_model* tables, struct haptable_frame_pair* line,
                                  uint8_t byte, uint8_t answer[HAPTABLE_FRAME_PAIR_BYTES]) {
    const int heard = haptable_frame_pair_hear(line, byte);
    if (heard == HAPTABLE_FRAME_PAIR_NOTHING) return 0;
    if (heard == HAPTABLE_FRAME_PAIR_TICK) tick(tables, line);
    return haptable_frame_pair_write(tables, line, answer);
}
