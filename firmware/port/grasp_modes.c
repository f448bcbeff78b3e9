/* SPDX-License-Identifier: MIT
 *
 * positions (float32[2][3], raw) -> haptable_body_modes_pair_step, a millisecond apart -> both forces, centre, turn
 * (float32[13], raw)
 *
 * As grasp.c, of a body that rings. Its words: grasp_modes IN OUT.
 */
#include "haptable_body_modes_pair.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "model.h"

static struct haptable_pair pair_state;
static struct haptable_body_state body_state;
static struct haptable_modes_pair modes_state;

int haptable_port_main(void) {
    float finger_m[HAPTABLE_FINGERS][3];
    uint32_t now_us = 0;
    int in;
    int out_file;
    const int status = haptable_semihosting_files(&in, &out_file);
    if (status != 0) return status;
    haptable_pair_init(HAPTABLE_MODEL_PAIR, &pair_state);
    haptable_pair_check(HAPTABLE_MODEL_PAIR, &pair_state, HAPTABLE_CHECK_ALL);
    haptable_body_init(&HAPTABLE_MODEL_BODY, &body_state);
    haptable_modes_pair_init(&modes_state);
    for (; haptable_semihosting_read(in, finger_m, sizeof finger_m) == sizeof finger_m; now_us += HAPTABLE_TICK_US) {
        struct haptable_output out[HAPTABLE_FINGERS];
        int finger;
        haptable_port_count_begin();
        haptable_body_modes_pair_step(HAPTABLE_MODEL_MODES, HAPTABLE_MODEL_PAIR, &HAPTABLE_MODEL_BODY, &body_state,
                                      &modes_state, &pair_state, (const float(*)[3])finger_m, now_us, out);
        haptable_port_count_end();
        for (finger = 0; finger < HAPTABLE_FINGERS; ++finger)
            haptable_semihosting_write(out_file, out[finger].force_n, sizeof out[finger].force_n);
        haptable_semihosting_write(out_file, body_state.position_m, sizeof body_state.position_m);
        haptable_semihosting_write(out_file, body_state.turn, sizeof body_state.turn);
    }
    return 0;
}
