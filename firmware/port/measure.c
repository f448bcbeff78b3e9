/* SPDX-License-Identifier: MIT
 *
 * Like replay.c, with a scene that it reads instead of one that it is linked with: every scene from one image, for
 * tests and counts. Its words: measure IN OUT. IN holds the scene as codegen/scene_bytes.cpp writes it, then the path.
 * The tables lie in RAM: for boards like QEMU's, with megabytes of it.
 */
#include "haptable_port.h"
#include "haptable_scene_reader.h"
#include "haptable_semihosting.h"
#include "haptable_ticks.h"

/* Where the tables go: those of two fingers in clusters on a body of 2,400 patches take a megabyte and more. */
static uint32_t room[384u * 1024u];
static struct haptable_points_scene scene;
/* As haptable_scene_make lays out the state of a scene that has everything; or a tool's, or hands'. */
static union {
    struct haptable_tool_room tool;
    struct haptable_hands_room hands;
    uint8_t bytes[sizeof(struct haptable_room) + sizeof(struct haptable_body_state) +
                  sizeof(struct haptable_modes_state) + sizeof(struct haptable_account) + 64];
    void* aligned;
} scene_state;

static uint32_t read_file(void* file, void* to, uint32_t bytes) {
    return haptable_semihosting_read(*(const int*)file, to, bytes);
}

static struct haptable_scene_reader reader = {
    .read = read_file, .room = room, .words = sizeof room / sizeof room[0], .is_whole = 1};

/* A tool's path has the handle's position and the vector part of its turn, of less than half; a record, in words, what
 * a finger's has and torque_n_m[3]. */
static void replay_tool(int in, int out) {
    float pose[6];
    uint32_t now_us = 0;
    haptable_init(&scene.scene, &scene_state);
    haptable_check(&scene.scene, &scene_state, HAPTABLE_CHECK_ALL);
    for (; haptable_semihosting_read(in, pose, sizeof pose) == sizeof pose; now_us += HAPTABLE_TICK_US) {
        struct haptable_tool_input tool = {.hand = {.is_there = 1}};
        struct haptable_tool_output tick;
        struct {
            uint32_t state, patch;
            float alpha[3], god_object_m[3], force_n[3], torque_n_m[3];
        } record;
        const float rest = 1.0f - pose[3] * pose[3] - pose[4] * pose[4] - pose[5] * pose[5];
        float guess = 1.0f;
        for (int i = 0; i < 8; ++i) guess = 0.5f * (guess + rest / guess); /* its root, by Newton's method */
        tool.turn[0] = guess;
        for (int i = 0; i < 3; ++i) {
            tool.hand.finger_m[i] = pose[i];
            tool.turn[1 + i] = pose[3 + i];
        }
        haptable_port_count_begin();
        haptable_step(&scene.scene, &scene_state, &tool.hand, now_us, &tick.hand);
        haptable_port_count_end();
        record.state = tick.hand.state;
        record.patch = tick.hand.patch;
        for (int i = 0; i < 3; ++i) {
            record.alpha[i] = tick.hand.alpha[i];
            record.god_object_m[i] = tick.hand.god_object_m[i];
            record.force_n[i] = tick.hand.force_n[i];
            record.torque_n_m[i] = tick.torque_n_m[i];
        }
        haptable_semihosting_write(out, &record, sizeof record);
    }
}

int haptable_port_main(void) {
    int in, out;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    reader.from = &in;
    if (!haptable_read_scene(&reader, &scene)) return 65;
    if (scene.points && !scene.scene.pair)
        replay_tool(in, out);
    else
        haptable_ticks_replay(&scene.scene, &scene_state, in, out);
    return 0;
}
