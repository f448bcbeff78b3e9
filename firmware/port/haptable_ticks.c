/* SPDX-License-Identifier: MIT
 *
 * What replay.c and measure.c share: a scene stepped through a path.
 */
#include "haptable_ticks.h"

#include "haptable.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"

#define POSITIONS 32 /* read at once: a call to the debugger costs more than a tick */
#define RECORD_WORDS (11u * HAPTABLE_HANDS + 7u + HAPTABLE_MODES)

/* Records on their way out. */
static struct {
    int file;
    uint32_t count;
    union {
        uint32_t bits;
        float number;
    } word[256];
} records;

static void flush(void) {
    haptable_semihosting_write(records.file, records.word, records.count * (uint32_t)sizeof records.word[0]);
    records.count = 0;
}

static void put_floats(const float* values, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) records.word[records.count++].number = values[i];
}

static void put_finger(const struct haptable_output* out) {
    records.word[records.count++].bits = out->state;
    records.word[records.count++].bits = out->patch;
    put_floats(out->alpha, 3);
    put_floats(out->god_object_m, 3);
    put_floats(out->force_n, 3);
}

static void make_room(void) {
    if (records.count + RECORD_WORDS > sizeof records.word / sizeof records.word[0]) flush();
}

static void put_tick(const struct haptable_scene* scene, void* state, const struct haptable_output out[]) {
    make_room();
    for (int f = 0; f < haptable_scene_fingers(scene); ++f) put_finger(&out[f]);
    if (scene->body) {
        put_floats(haptable_scene_body(scene, state)->position_m, 3);
        put_floats(haptable_scene_body(scene, state)->turn, 4);
    }
    if (scene->modes) put_floats(haptable_scene_modes(scene, state)->q, scene->modes->count);
}

__attribute__((noinline)) void haptable_port_count_begin(void) { __asm volatile("" ::: "memory"); }
__attribute__((noinline)) void haptable_port_count_end(void) { __asm volatile("" ::: "memory"); }

void haptable_ticks_replay(const struct haptable_scene* scene, void* state, int in, int out) {
    const uint32_t fingers = (uint32_t)haptable_scene_fingers(scene);
    float position_m[POSITIONS][3];
    const uint32_t whole = (uint32_t)sizeof position_m[0] * (POSITIONS - POSITIONS % fingers);
    uint32_t now_us = 0;
    uint32_t bytes;
    records.file = out;
    haptable_init(scene, state);
    haptable_check(scene, state, HAPTABLE_CHECK_ALL);
    while ((bytes = haptable_semihosting_read(in, position_m, whole)) > 0) {
        for (uint32_t i = 0; i < bytes / sizeof position_m[0]; i += fingers, now_us += HAPTABLE_TICK_US) {
            struct haptable_input finger[HAPTABLE_HANDS];
            struct haptable_output tick[HAPTABLE_HANDS];
            for (uint32_t f = 0; f < fingers; ++f) {
                for (int c = 0; c < 3; ++c) finger[f].finger_m[c] = position_m[i + f][c];
                finger[f].buttons = 0;
                finger[f].is_there = 1;
            }
            haptable_port_count_begin();
            haptable_step(scene, state, finger, now_us, tick);
            haptable_port_count_end();
            put_tick(scene, state, tick);
        }
    }
    flush();
}

void haptable_ticks_replay_tool(const struct haptable_scene* scene, void* state, int in, int out) {
    float pose[6];
    uint32_t now_us = 0;
    records.file = out;
    haptable_init(scene, state);
    haptable_check(scene, state, HAPTABLE_CHECK_ALL);
    for (; haptable_semihosting_read(in, pose, sizeof pose) == sizeof pose; now_us += HAPTABLE_TICK_US) {
        struct haptable_tool_input tool = {.hand = {.is_there = 1}};
        struct haptable_tool_output tick;
        const float rest = 1.0f - pose[3] * pose[3] - pose[4] * pose[4] - pose[5] * pose[5];
        float guess = 1.0f;
        for (int i = 0; i < 8; ++i) guess = 0.5f * (guess + rest / guess); /* its root, by Newton's method */
        tool.turn[0] = guess;
        for (int i = 0; i < 3; ++i) {
            tool.hand.finger_m[i] = pose[i];
            tool.turn[1 + i] = pose[3 + i];
        }
        haptable_port_count_begin();
        haptable_step(scene, state, &tool.hand, now_us, &tick.hand);
        haptable_port_count_end();
        make_room();
        put_finger(&tick.hand);
        put_floats(tick.torque_n_m, 3);
    }
    flush();
}
