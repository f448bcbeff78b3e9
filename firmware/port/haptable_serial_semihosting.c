/* SPDX-License-Identifier: MIT
 *
 * The line as two files of the debugger's machine, which may be named pipes: the words IN OUT of the command line.
 */
#include "haptable_port.h"
#include "haptable_semihosting.h"

static int in_file;
static int out_file;

int haptable_serial_open(void) { return haptable_semihosting_files(&in_file, &out_file); }

int haptable_serial_read(uint8_t* byte) {
    /* A pipe gives what it has, up to so many: a call to the debugger costs more than a tick. */
    static uint8_t buffer[64];
    static uint32_t count;
    static uint32_t next;
    if (next == count) {
        count = haptable_semihosting_read(in_file, buffer, sizeof buffer);
        next = 0;
        if (count == 0) return 0;
    }
    *byte = buffer[next++];
    return 1;
}

void haptable_serial_write(const uint8_t* bytes, uint32_t count) { haptable_semihosting_write(out_file, bytes, count); }
