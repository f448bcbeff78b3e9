/* SPDX-License-Identifier: MIT
 *
 * positions (float32[3], raw) -> haptable_step, a millisecond apart -> haptable_deform -> displacements (float32, raw)
 *
 * The image that shows that a target computes the host's displacements. Its words: deform IN OUT, files by semihosting.
 */
#include "display.h"
#include "haptable_deformation.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "model.h"

static struct haptable_servo servo_state;
static float displacement_m[HAPTABLE_DISPLAY_ROWS][3];

int haptable_port_main(void) {
    float position_m[3];
    uint32_t now_us = 0;
    int in;
    int out_file;
    const int status = haptable_semihosting_files(&in, &out_file);
    if (status != 0) return status;
    haptable_init(&servo_state);
    haptable_check(&HAPTABLE_MODEL, &servo_state, HAPTABLE_CHECK_ALL);
    for (; haptable_semihosting_read(in, position_m, sizeof position_m) == sizeof position_m;
         now_us += HAPTABLE_TICK_US) {
        struct haptable_output out;
        haptable_step(&HAPTABLE_MODEL, &servo_state, position_m, now_us, &out);
        haptable_deform(&HAPTABLE_DISPLAY, &out, displacement_m);
        haptable_semihosting_write(out_file, displacement_m, sizeof displacement_m);
    }
    return 0;
}
