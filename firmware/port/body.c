/* SPDX-License-Identifier: MIT
 *
 * positions (float32[3], raw) -> haptable_body_step, a millisecond apart -> force, centre, turn (float32[10], raw)
 *
 * The image that shows that a target moves a body that nothing holds as the host does. Its words: body IN OUT, files by
 * semihosting.
 */
#include "haptable_body.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "model.h"

static struct haptable_servo servo_state;
static struct haptable_body_state body_state;

int haptable_port_main(void) {
    float finger_m[1][3];
    uint32_t now_us = 0;
    int in;
    int out_file;
    const int status = haptable_semihosting_files(&in, &out_file);
    if (status != 0) return status;
    haptable_init(&servo_state);
    haptable_check(&HAPTABLE_MODEL, &servo_state, HAPTABLE_CHECK_ALL);
    haptable_body_init(&HAPTABLE_MODEL_BODY, &body_state);
    for (; haptable_semihosting_read(in, finger_m, sizeof finger_m) == sizeof finger_m; now_us += HAPTABLE_TICK_US) {
        struct haptable_output out;
        haptable_port_count_begin();
        haptable_body_step(&HAPTABLE_MODEL, &HAPTABLE_MODEL_BODY, &body_state, &servo_state, 1,
                           (const float(*)[3])finger_m, now_us, &out);
        haptable_port_count_end();
        haptable_semihosting_write(out_file, out.force_n, sizeof out.force_n);
        haptable_semihosting_write(out_file, body_state.position_m, sizeof body_state.position_m);
        haptable_semihosting_write(out_file, body_state.turn, sizeof body_state.turn);
    }
    return 0;
}
