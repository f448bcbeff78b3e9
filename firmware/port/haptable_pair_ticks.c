/* SPDX-License-Identifier: MIT
 *
 * What pair.c and measure_pair.c share: two servos stepped through a path of two fingers.
 */
#include "haptable_pair_ticks.h"

#include "haptable_port.h"
#include "haptable_semihosting.h"

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

void haptable_pair_ticks_replay(const struct haptable_pair_model* tables, int in, int out) {
    float position_m[HAPTABLE_FINGERS][3];
    uint32_t now_us = 0;
    haptable_pair_init(tables, &pair_state);
    haptable_pair_check(tables, &pair_state, HAPTABLE_CHECK_ALL);
    for (; haptable_semihosting_read(in, position_m, sizeof position_m) == sizeof position_m;
         now_us += HAPTABLE_TICK_US) {
        struct haptable_output tick[HAPTABLE_FINGERS];
        haptable_port_count_begin();
        haptable_pair_step(tables, &pair_state, position_m[0], position_m[1], now_us, tick);
        haptable_port_count_end();
        put(tick, out);
    }
}
