/* SPDX-License-Identifier: MIT
 *
 * positions (float32[2][3], raw) -> haptable_pair_step, a millisecond apart -> a record of both fingers a tick
 *
 * The image that shows that a target computes what the host computes, of a scene with two fingers. Its words: pair IN
 * OUT, files by semihosting. A record: of each finger state, patch, and the bits of alpha, god-object and force.
 */
#include "haptable_pair.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "model.h"

struct record {
    uint32_t state;
    uint32_t patch;
    float alpha[3];
    float god_object_m[3];
    float force_n[3];
};

static struct haptable_pair pair_state;

static void put(const struct haptable_output out[HAPTABLE_FINGERS], int file) {
    struct record record[HAPTABLE_FINGERS];
    int finger;
    int c;
    for (finger = 0; finger < HAPTABLE_FINGERS; ++finger) {
        record[finger].state = out[finger].state;
        record[finger].patch = out[finger].patch;
        for (c = 0; c < 3; ++c) {
            record[finger].alpha[c] = out[finger].alpha[c];
            record[finger].god_object_m[c] = out[finger].god_object_m[c];
            record[finger].force_n[c] = out[finger].force_n[c];
        }
    }
    haptable_semihosting_write(file, record, sizeof record);
}

int haptable_port_main(void) {
    const struct haptable_pair_model* tables = HAPTABLE_MODEL_PAIR;
    float position_m[HAPTABLE_FINGERS][3];
    uint32_t now_us = 0;
    int in;
    int out;
    int finger;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    haptable_pair_init(tables, &pair_state);
    for (finger = 0; finger < HAPTABLE_FINGERS; ++finger)
        haptable_check(tables->model, &pair_state.servo[finger], HAPTABLE_CHECK_ALL);
    for (; haptable_semihosting_read(in, position_m, sizeof position_m) == sizeof position_m;
         now_us += HAPTABLE_TICK_US) {
        struct haptable_output tick[HAPTABLE_FINGERS];
        haptable_port_count_begin();
        haptable_pair_step(tables, &pair_state, (const float(*)[3])position_m, now_us,
                           tick); /* C99 adds no const there */
        haptable_port_count_end();
        put(tick, out);
    }
    return 0;
}
