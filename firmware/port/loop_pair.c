/* SPDX-License-Identifier: MIT
 *
 * frames in -> haptable_pair_step, or haptable_step of one -> frames out, for ever
 *
 * The servo of two fingers behind a serial line, as loop.c is that of one: loop_pair.elf has two files of the
 * debugger's machine as its line, uart_pair.elf the part's UART. Time is that of the frames.
 */
#include "haptable_frame_pair.h"
#include "haptable_line.h"
#include "haptable_port.h"
#include "model.h"

static struct haptable_frame_pair servo_line;
static uint8_t answer[HAPTABLE_FRAME_PAIR_BYTES];

int haptable_port_main(void) {
    const int status = haptable_line_open();
    uint8_t byte;
    if (status != 0) return status;
    haptable_frame_pair_init(HAPTABLE_MODEL_PAIR, &servo_line);
    while (haptable_line_read(&byte)) {
        const uint32_t length = haptable_frame_pair_take(HAPTABLE_MODEL_PAIR, &servo_line, byte, answer);
        if (length == 0) continue;
        haptable_line_write(answer, length);
        haptable_pair_check(HAPTABLE_MODEL_PAIR, &servo_line.pair, HAPTABLE_CHECK_BYTES);
    }
    return 0;
}
