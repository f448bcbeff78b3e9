/* SPDX-License-Identifier: MIT
 *
 * frames in -> haptable_modes_step -> frames out, for ever
 *
 * The servo of a body that rings behind a serial line, as loop.c is that of one that follows at once: loop_modes.elf
 * has two files of the debugger's machine as its line, uart_modes.elf the part's UART. Time is that of the frames.
 */
#include "haptable_frame_modes.h"
#include "haptable_line.h"
#include "haptable_port.h"
#include "model.h"

static struct haptable_frame_modes servo_line;
static uint8_t answer[HAPTABLE_FRAME_RINGING_BYTES];

int haptable_port_main(void) {
    const int status = haptable_line_open();
    uint8_t byte;
    if (status != 0) return status;
    haptable_frame_modes_init(HAPTABLE_MODEL_MODES, &servo_line);
    while (haptable_line_read(&byte)) {
        const uint32_t length = haptable_frame_modes_take(HAPTABLE_MODEL_MODES, &servo_line, byte, answer);
        if (length == 0) continue;
        haptable_line_write(answer, length);
        haptable_check(&HAPTABLE_MODEL, &servo_line.servo, HAPTABLE_CHECK_BYTES);
    }
    return 0;
}
