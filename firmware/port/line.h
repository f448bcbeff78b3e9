/* SPDX-License-Identifier: MIT
 *
 * The serial line of an image that speaks frames. One file stands behind it: line_semihosting.c (two files of the
 * debugger's machine), or a port's UART (uart_cmsdk.c, uart_16550.c).
 */
#ifndef HAPTABLE_LINE_H
#define HAPTABLE_LINE_H

#include <stdint.h>

/* Returns 0, or the exit status that says why there is no line. */
int line_open(void);

/* Waits for a byte. Returns 0 when the line has ended. */
int line_read(uint8_t* byte);

void line_write(const uint8_t* bytes, uint32_t count);

#endif
