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

int haptable_port_main(void) {
    int in, out;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    reader.from = &in;
    if (!haptable_read_scene(&reader, &scene)) return 65;
    if (scene.points && !scene.scene.pair)
        haptable_ticks_replay_tool(&scene.scene, &scene_state, in, out);
    else
        haptable_ticks_replay(&scene.scene, &scene_state, in, out);
    return 0;
}
