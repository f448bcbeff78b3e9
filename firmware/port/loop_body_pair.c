/* SPDX-License-Identifier: MIT
 *
 * frames in -> haptable_body_pair_step, or haptable_body_step_finger of one -> frames out, for ever
 *
 * The servo of two fingers on a body that nothing holds behind a serial line, as loop_pair.c is that of one that is
 * held: loop_body_pair.elf and uart_body_pair.elf. Time is that of the frames.
 */
#include "haptable_frame_body_pair.h"
#include "haptable_line.h"
#include "haptable_port.h"
#include "model.h"

static struct haptable_frame_body_pair servo_line;
static uint8_t answer[HAPTABLE_FRAME_BODY_PAIR_BYTES];

int haptable_port_main(void) {
    const int status = haptable_line_open();
    uint8_t byte;
    if (status != 0) return status;
    haptable_frame_body_pair_init(HAPTABLE_MODEL_PAIR, &HAPTABLE_MODEL_BODY, &servo_line);
    while (haptable_line_read(&byte)) {
        const uint32_t length =
            haptable_frame_body_pair_take(HAPTABLE_MODEL_PAIR, &HAPTABLE_MODEL_BODY, &servo_line, byte, answer);
        if (length == 0) continue;
        haptable_line_write(answer, length);
        haptable_pair_check(HAPTABLE_MODEL_PAIR, &servo_line.fingers.pair, HAPTABLE_CHECK_BYTES);
    }
    return 0;
}
