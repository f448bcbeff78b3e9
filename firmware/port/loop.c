/* SPDX-License-Identifier: MIT
 *
 * frames in -> haptable_step -> frames out, for ever
 *
 * The servo behind a serial line: loop.elf has two files of the debugger's machine as its line, uart.elf the part's
 * UART. Time is that of the frames.
 */
#include "haptable_line_points.h"
#include "haptable_port.h"
#include "model.h"

static HAPTABLE_MODEL_STATE scene_state;
static HAPTABLE_MODEL_LINE_END line;

int haptable_port_main(void) {
    const int status = haptable_serial_open();
    const uint8_t* bytes;
    uint32_t count;
    uint8_t byte;
    if (status != 0) return status;
    haptable_init(&HAPTABLE_MODEL_SCENE, &scene_state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &scene_state, HAPTABLE_CHECK_ALL);
    bytes = HAPTABLE_MODEL_LINE_BEGIN(&HAPTABLE_MODEL_SCENE, &line, &count);
    haptable_serial_write(bytes, count);
    while (haptable_serial_read(&byte)) {
        bytes = HAPTABLE_MODEL_LINE(&HAPTABLE_MODEL_SCENE, &scene_state, &line, byte, &count);
        if (count == 0) continue;
        haptable_serial_write(bytes, count);
        haptable_check(&HAPTABLE_MODEL_SCENE, &scene_state, HAPTABLE_CHECK_BYTES);
    }
    return 0;
}
