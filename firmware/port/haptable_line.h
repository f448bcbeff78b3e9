/* SPDX-License-Identifier: MIT
 *
 * The serial line of an image that speaks frames. One file stands behind it: haptable_line_semihosting.c (two files of
 * the debugger's machine), or a port's UART (haptable_uart_cmsdk.c, haptable_uart_16550.c).
 */
#ifndef HAPTABLE_LINE_H
#define HAPTABLE_LINE_H

#include <stdint.h>

/* Returns 0, or the exit status that says why there is no line. */
int haptable_line_open(void);

/* Waits for a byte. Returns 0 when the line has ended. */
int haptable_line_read(uint8_t* byte);

void haptable_line_write(const uint8_t* bytes, uint32_t count);

#endif
