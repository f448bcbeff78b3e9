/* SPDX-License-Identifier: MIT
 *
 * See haptable_frame_modes.h.
 */
#include "haptable_frame_modes.h"

#include "haptable_crc.h"
#include "haptable_frame_bytes.h"

#define HEAD 8u /* bytes before the payload */

uint32_t haptable_frame_write_modes(uint32_t sequence, const float* q, uint8_t count,
                                    uint8_t bytes[HAPTABLE_FRAME_MODES_BYTES]) {
    uint8_t* to = frame_put_word(bytes + 4, sequence);
    bytes[0] = 0xA5u;
    bytes[1] = 0x5Au;
    bytes[2] = (uint8_t)(4u * count);
    bytes[3] = HAPTABLE_FRAME_MODES;
    to = frame_put_floats(to, q, count);
    to = frame_put_word(to, ~haptable_crc(HAPTABLE_CRC_BEGIN, bytes + 2, HEAD - 2u + bytes[2]));
    return (uint32_t)(to - bytes);
}

uint8_t haptable_frame_take_modes(const struct haptable_frame* frame, struct haptable_swings* swings) {
    const uint8_t count = (uint8_t)(frame->length / 4u);
    if (frame->type != HAPTABLE_FRAME_MODES || frame->length % 4u != 0u || count > HAPTABLE_MODES) return 0;
    (void)frame_take_floats(frame->payload, swings->q, count);
    return count;
}

void haptable_frame_modes_init(const struct haptable_modes* modes, struct haptable_frame_modes* line) {
    haptable_init(&line->servo);
    haptable_check(modes->model, &line->servo, HAPTABLE_CHECK_ALL);
    haptable_modes_init(&line->state);
    haptable_frame_reader_init(&line->reader);
    line->sequence = 0;
    line->time_us = 0;
    line->is_stepped = 0;
}

/* A gap in time drops the contact, as silence does. */
static void tick(const struct haptable_modes* modes, const struct haptable_frame_state* state,
                 struct haptable_frame_modes* line) {
    (void)haptable_watch(&line->servo, state->time_us, &line->out);
    haptable_buttons(&line->servo, state->buttons);
    haptable_modes_step(modes, &line->state, &line->servo, state->position_m, state->time_us, &line->out);
}

uint32_t haptable_frame_modes_take(const struct haptable_modes* modes, struct haptable_frame_modes* line, uint8_t byte,
                                   uint8_t answer[HAPTABLE_FRAME_RINGING_BYTES]) {
    struct haptable_frame frame;
    struct haptable_frame_state state;
    uint32_t length;
    if (!haptable_frame_read(&line->reader, byte, &frame) || !haptable_frame_take_state(&frame, &state)) return 0;
    if (!line->is_stepped || frame.sequence != line->sequence || state.time_us != line->time_us) {
        line->sequence = frame.sequence;
        line->time_us = state.time_us;
        line->is_stepped = 1;
        tick(modes, &state, line);
    }
    length = haptable_frame_write_modes(line->sequence, line->state.swings.q, modes->count, answer);
    return length + haptable_frame_write_force(line->sequence, modes->model->hash, &line->out, answer + length);
}
