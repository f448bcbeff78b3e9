/* SPDX-License-Identifier: MIT
 *
 * frames in -> haptable_body_step -> frames out, for ever
 *
 * The servo of a body that nothing holds behind a serial line, as loop.c is that of one that is held: loop_body.elf has
 * two files of the debugger's machine as its line, uart_body.elf the part's UART. Time is that of the frames.
 */
#include "haptable_frame_body.h"
#include "haptable_line.h"
#include "haptable_port.h"
#include "model.h"

static struct haptable_frame_body servo_line;
static uint8_t answer[HAPTABLE_FRAME_BODY_BYTES];

int haptable_port_main(void) {
    const int status = haptable_line_open();
    uint8_t byte;
    if (status != 0) return status;
    haptable_frame_body_init(&HAPTABLE_MODEL, &HAPTABLE_MODEL_BODY, &servo_line);
    while (haptable_line_read(&byte)) {
        const uint32_t length =
            haptable_frame_body_take(&HAPTABLE_MODEL, &HAPTABLE_MODEL_BODY, &servo_line, byte, answer);
        if (length == 0) continue;
        haptable_line_write(answer, length);
        haptable_check(&HAPTABLE_MODEL, &servo_line.servo, HAPTABLE_CHECK_BYTES);
    }
    return 0;
}
