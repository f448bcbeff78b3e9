/* SPDX-License-Identifier: MIT
 *
 * See haptable_frame_body.h.
 */
#include "haptable_frame_body.h"

#include "haptable_crc.h"
#include "haptable_frame_bytes.h"

#define HEAD 8u /* bytes before the payload */

uint32_t haptable_frame_write_pose(uint32_t sequence, const struct haptable_body_state* body,
                                   uint8_t bytes[HAPTABLE_FRAME_POSE_BYTES]) {
    uint8_t* to = frame_put_word(bytes + 4, sequence);
    bytes[0] = 0xA5u;
    bytes[1] = 0x5Au;
    bytes[2] = HAPTABLE_FRAME_POSE_PAYLOAD;
    bytes[3] = HAPTABLE_FRAME_POSE;
    to = frame_put_floats(to, body->position_m, 3);
    to = frame_put_floats(to, body->turn, 4);
    to = frame_put_floats(to, body->velocity_m_per_s, 3);
    to = frame_put_floats(to, body->spin_rad_per_s, 3);
    to = frame_put_word(to, body->on_floor);
    (void)frame_put_word(to, ~haptable_crc(HAPTABLE_CRC_BEGIN, bytes + 2, HEAD - 2u + HAPTABLE_FRAME_POSE_PAYLOAD));
    return HAPTABLE_FRAME_POSE_BYTES;
}

int haptable_frame_take_pose(const struct haptable_frame* frame, struct haptable_body_state* body) {
    const uint8_t* from = frame->payload;
    if (frame->type != HAPTABLE_FRAME_POSE || frame->length != HAPTABLE_FRAME_POSE_PAYLOAD) return 0;
    from = frame_take_floats(from, body->position_m, 3);
    from = frame_take_floats(from, body->turn, 4);
    from = frame_take_floats(from, body->velocity_m_per_s, 3);
    from = frame_take_floats(from, body->spin_rad_per_s, 3);
    body->on_floor = (uint8_t)frame_word_at(from);
    return 1;
}

void haptable_frame_body_init(const struct haptable_model* model, const struct haptable_body* body,
                              struct haptable_frame_body* line) {
    haptable_init(&line->servo);
    haptable_check(model, &line->servo, HAPTABLE_CHECK_ALL);
    haptable_body_init(body, &line->body);
    haptable_frame_reader_init(&line->reader);
    line->sequence = 0;
    line->time_us = 0;
    line->is_stepped = 0;
}

/* A gap in time drops the contact, as silence does. */
static void tick(const struct haptable_model* model, const struct haptable_body* body,
                 const struct haptable_frame_state* state, struct haptable_frame_body* line) {
    const float(*finger_m)[3] = &state->position_m;
    (void)haptable_watch(&line->servo, state->time_us, &line->out);
    haptable_buttons(&line->servo, state->buttons);
    (void)haptable_frame_write_pose(line->sequence, &line->body, line->pose);
    haptable_body_step(model, body, &line->body, &line->servo, 1, finger_m, state->time_us, &line->out);
}

uint32_t haptable_frame_body_take(const struct haptable_model* model, const struct haptable_body* body,
                                  struct haptable_frame_body* line, uint8_t byte,
                                  uint8_t answer[HAPTABLE_FRAME_BODY_BYTES]) {
    struct haptable_frame frame;
    struct haptable_frame_state state;
    uint32_t i;
    if (!haptable_frame_read(&line->reader, byte, &frame) || !haptable_frame_take_state(&frame, &state)) return 0;
    if (!line->is_stepped || frame.sequence != line->sequence || state.time_us != line->time_us) {
        line->sequence = frame.sequence;
        line->time_us = state.time_us;
        line->is_stepped = 1;
        tick(model, body, &state, line);
    }
    for (i = 0; i < HAPTABLE_FRAME_POSE_BYTES; ++i) answer[i] = line->pose[i];
    return i + haptable_frame_write_force(line->sequence, model->hash, &line->out, answer + i);
}
