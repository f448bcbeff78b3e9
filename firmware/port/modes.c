/* SPDX-License-Identifier: MIT
 *
 * positions (float32[3], raw) -> haptable_modes_step, a millisecond apart -> force, shift (float32[6], raw)
 *
 * The image that shows that a target rings as the host does. Its words: modes IN OUT, files by semihosting.
 */
#include "haptable_modes.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "model.h"

static struct haptable_servo servo_state;
static struct haptable_modes_state modes_state;

int haptable_port_main(void) {
    float finger_m[3];
    uint32_t now_us = 0;
    int in;
    int out_file;
    const int status = haptable_semihosting_files(&in, &out_file);
    if (status != 0) return status;
    haptable_init(&servo_state);
    haptable_check(&HAPTABLE_MODEL, &servo_state, HAPTABLE_CHECK_ALL);
    haptable_modes_init(&modes_state);
    for (; haptable_semihosting_read(in, finger_m, sizeof finger_m) == sizeof finger_m; now_us += HAPTABLE_TICK_US) {
        struct haptable_output out;
        haptable_port_count_begin();
        haptable_modes_step(HAPTABLE_MODEL_MODES, &modes_state, &servo_state, finger_m, now_us, &out);
        haptable_port_count_end();
        haptable_semihosting_write(out_file, out.force_n, sizeof out.force_n);
        haptable_semihosting_write(out_file, modes_state.met.shift_m, sizeof modes_state.met.shift_m);
    }
    return 0;
}
