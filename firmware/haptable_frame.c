/* SPDX-License-Identifier: MIT
 *
 * See haptable_frame.h.
 */
#include "haptable_frame.h"

#include "haptable_crc.h"
#include "haptable_frame_bytes.h"

#define SYNC_0 0xA5u
#define SYNC_1 0x5Au
#define HEAD 8u /* bytes before the payload */
#define TAIL 4u /* bytes after it */

static uint32_t crc_of(const uint8_t* bytes, uint32_t count) { return ~haptable_crc(HAPTABLE_CRC_BEGIN, bytes, count); }

/* ---- reading --------------------------------------------------------------------------------------------------- */

void haptable_frame_reader_init(struct haptable_frame_reader* reader) {
    reader->count = 0;
    reader->frames = 0;
    reader->skipped_bytes = 0;
}

/* Forgets the first bytes: count is small, and this happens once a frame or once a byte of garbage. */
static void drop(struct haptable_frame_reader* reader, uint8_t bytes) {
    uint8_t i;
    reader->count = (uint8_t)(reader->count - bytes);
    for (i = 0; i < reader->count; ++i) reader->byte[i] = reader->byte[i + bytes];
}

/* What the bytes so far are: the begin of a frame (0), a whole frame (1), or neither (-1). */
static int judge(const struct haptable_frame_reader* reader) {
    const uint8_t* byte = reader->byte;
    uint32_t whole;
    if (reader->count > 0 && byte[0] != SYNC_0) return -1;
    if (reader->count > 1 && byte[1] != SYNC_1) return -1;
    if (reader->count > 2 && byte[2] > HAPTABLE_FRAME_PAYLOAD) return -1;
    if (reader->count < 3) return 0;
    whole = HEAD + byte[2] + TAIL;
    if (reader->count < whole) return 0;
    return crc_of(byte + 2, whole - 2u - TAIL) == frame_word_at(byte + whole - TAIL) ? 1 : -1;
}

int haptable_frame_read(struct haptable_frame_reader* reader, uint8_t byte, struct haptable_frame* frame) {
    int verdict;
    /* The frame that was handed out stands at the begin until now. */
    if (reader->count > 0 && judge(reader) == 1) drop(reader, (uint8_t)(HEAD + reader->byte[2] + TAIL));
    reader->byte[reader->count++] = byte;
    while ((verdict = judge(reader)) < 0) {
        ++reader->skipped_bytes;
        drop(reader, 1);
    }
    if (verdict == 0) return 0;
    ++reader->frames;
    frame->length = reader->byte[2];
    frame->type = reader->byte[3];
    frame->sequence = frame_word_at(reader->byte + 4);
    frame->payload = reader->byte + HEAD;
    return 1;
}

int haptable_frame_take_state(const struct haptable_frame* frame, struct haptable_frame_state* state) {
    if (frame->type != HAPTABLE_FRAME_STATE || frame->length != HAPTABLE_FRAME_STATE_PAYLOAD) return 0;
    state->time_us = frame_word_at(frame->payload);
    state->buttons = frame_word_at(frame_take_floats(frame->payload + 4, state->position_m, 3));
    return 1;
}

int haptable_frame_take_force(const struct haptable_frame* frame, uint64_t* model_hash, struct haptable_output* out) {
    const uint8_t* from = frame->payload;
    int corner;
    if (frame->type != HAPTABLE_FRAME_FORCE || frame->length != HAPTABLE_FRAME_FORCE_PAYLOAD) return 0;
    *model_hash = frame_word_at(from) | ((uint64_t)frame_word_at(from + 4) << 32);
    out->state = from[8];
    out->faults = from[9];
    for (corner = 0; corner < 3; ++corner)
        out->vertex[corner] = (uint16_t)(from[10 + 2 * corner] | (from[11 + 2 * corner] << 8));
    from = frame_take_floats(from + 16, out->force_n, 3);
    from = frame_take_floats(from, out->god_object_m, 3);
    from = frame_take_floats(from, out->alpha, 3);
    for (corner = 0; corner < 3; ++corner) from = frame_take_floats(from, out->nodal_force_n[corner], 3);
    return 1;
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

static uint8_t* begin_frame(uint8_t type, uint8_t length, uint32_t sequence, uint8_t* bytes) {
    bytes[0] = SYNC_0;
    bytes[1] = SYNC_1;
    bytes[2] = length;
    bytes[3] = type;
    return frame_put_word(bytes + 4, sequence);
}

static uint32_t end_frame(uint8_t* bytes) {
    const uint32_t before_crc = HEAD + bytes[2];
    frame_put_word(bytes + before_crc, crc_of(bytes + 2, before_crc - 2u));
    return before_crc + TAIL;
}

uint32_t haptable_frame_write_state(uint32_t sequence, const struct haptable_frame_state* state,
                                    uint8_t bytes[HAPTABLE_FRAME_BYTES]) {
    uint8_t* to = begin_frame(HAPTABLE_FRAME_STATE, HAPTABLE_FRAME_STATE_PAYLOAD, sequence, bytes);
    to = frame_put_word(to, state->time_us);
    to = frame_put_floats(to, state->position_m, 3);
    frame_put_word(to, state->buttons);
    return end_frame(bytes);
}

uint32_t haptable_frame_write_force(uint32_t sequence, uint64_t model_hash, const struct haptable_output* out,
                                    uint8_t bytes[HAPTABLE_FRAME_BYTES]) {
    uint8_t* to = begin_frame(HAPTABLE_FRAME_FORCE, HAPTABLE_FRAME_FORCE_PAYLOAD, sequence, bytes);
    int corner;
    to = frame_put_word(to, (uint32_t)model_hash);
    to = frame_put_word(to, (uint32_t)(model_hash >> 32));
    *to++ = out->state;
    *to++ = out->faults;
    for (corner = 0; corner < 3; ++corner) {
        *to++ = (uint8_t)out->vertex[corner];
        *to++ = (uint8_t)(out->vertex[corner] >> 8);
    }
    to = frame_put_floats(to, out->force_n, 3);
    to = frame_put_floats(to, out->god_object_m, 3);
    to = frame_put_floats(to, out->alpha, 3);
    for (corner = 0; corner < 3; ++corner) to = frame_put_floats(to, out->nodal_force_n[corner], 3);
    return end_frame(bytes);
}
