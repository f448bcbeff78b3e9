/* SPDX-License-Identifier: MIT
 *
 * See haptable_frame_body_pair.h.
 */
#include "haptable_frame_body_pair.h"

#include "haptable_vector.h"

#define FIRST 1u
#define BOTH 3u

void haptable_frame_body_pair_init(const struct haptable_pair_model* tables, const struct haptable_body* body,
                                   struct haptable_frame_body_pair* line) {
    haptable_frame_pair_init(tables, &line->fingers);
    haptable_body_init(body, &line->body);
}

static void tick(const struct haptable_pair_model* tables, const struct haptable_body* body,
                 struct haptable_frame_body_pair* line) {
    struct haptable_frame_pair* fingers = &line->fingers;
    const int one = fingers->fingers == FIRST ? 0 : 1;
    (void)haptable_frame_write_pose(fingers->sequence, &line->body, line->pose);
    if (fingers->fingers == BOTH) {
        float finger_m[HAPTABLE_FINGERS][3];
        vec_copy(fingers->state[0].position_m, finger_m[0]);
        vec_copy(fingers->state[1].position_m, finger_m[1]);
        haptable_body_pair_step(tables, body, &line->body, &fingers->pair, (const float(*)[3])finger_m,
                                fingers->time_us, fingers->out);
    } else {
        haptable_body_step_finger(tables->model, body, &line->body, &fingers->pair.servo[one], one,
                                  fingers->state[one].position_m, fingers->time_us, &fingers->out[one]);
    }
}

uint32_t haptable_frame_body_pair_take(const struct haptable_pair_model* tables, const struct haptable_body* body,
                                       struct haptable_frame_body_pair* line, uint8_t byte,
                                       uint8_t answer[HAPTABLE_FRAME_BODY_PAIR_BYTES]) {
    const int heard = haptable_frame_pair_hear(&line->fingers, byte);
    uint32_t length = 0;
    if (heard == HAPTABLE_FRAME_PAIR_NOTHING) return 0;
    if (heard == HAPTABLE_FRAME_PAIR_TICK) tick(tables, body, line);
    if (!line->fingers.is_asked)
        for (; length < HAPTABLE_FRAME_POSE_BYTES; ++length) answer[length] = line->pose[length];
    return length + haptable_frame_pair_write(tables, &line->fingers, answer + length);
}
