/* SPDX-License-Identifier: MIT
 *
 * positions (float32[3], raw) -> haptable_step, a millisecond apart -> haptable_deform -> displacements (float32,
 * raw)
 *
 * The image that shows that a target computes the host's displacements under one finger. Its words: deform IN OUT,
 * files by semihosting.
 */
#include "display.h"
#include "haptable_deformation.h"
#include "haptable_port.h"
#include "haptable_scene.h"
#include "haptable_semihosting.h"
#include "model.h"

static HAPTABLE_MODEL_STATE scene_state;
static struct haptable_input finger[HAPTABLE_MODEL_FINGERS];
static struct haptable_output tick[HAPTABLE_MODEL_FINGERS];
static float displacement_m[HAPTABLE_DISPLAY_ROWS][3];

int haptable_port_main(void) {
    uint32_t now_us = 0;
    int in;
    int out;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    haptable_init(&HAPTABLE_MODEL_SCENE, &scene_state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &scene_state, HAPTABLE_CHECK_ALL);
    finger[0].is_there = 1;
    for (; haptable_semihosting_read(in, finger[0].finger_m, sizeof finger[0].finger_m) == sizeof finger[0].finger_m;
         now_us += HAPTABLE_TICK_US) {
        haptable_step(&HAPTABLE_MODEL_SCENE, &scene_state, finger, now_us, tick);
        haptable_deform(&HAPTABLE_DISPLAY, &tick[0], displacement_m);
        haptable_semihosting_write(out, displacement_m, sizeof displacement_m);
    }
    return 0;
}
