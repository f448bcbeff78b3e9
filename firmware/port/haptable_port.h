/* SPDX-License-Identifier: MIT
 *
 * What an image needs of its machine, and nothing more: time, a way to stop, a line, marks for an instruction counter.
 * One file a processor family stands behind it (haptable_cortex_m.c, haptable_riscv.c); the servo itself knows no
 * machine.
 */
#ifndef HAPTABLE_PORT_H
#define HAPTABLE_PORT_H

#include <stdint.h>

/* Starts the tick source. To be called once, by an image that has use for time. */
void haptable_port_init(void);

/* Microseconds since haptable_port_init; wraps after 71 minutes, as haptable_step allows. */
uint32_t haptable_port_now_us(void);

/* The image's program. Returns its exit status; what a debugger or QEMU reports. */
int haptable_port_main(void);

/* Called at reset with a stack and nothing else: makes memory what C wants, runs the program, and ends the image. */
void haptable_port_begin(void);

/* The serial line of an image that speaks frames: files of the debugger's machine (haptable_serial_semihosting.c) or
 * the part's UART (haptable_uart_cmsdk.c, haptable_uart_16550.c). Opening returns 0, or the exit status that says why
 * there is no line; reading waits for a byte, and returns 0 when the line has ended. */
int haptable_serial_open(void);
int haptable_serial_read(uint8_t* byte);
void haptable_serial_write(const uint8_t* bytes, uint32_t count);

/* Empty functions around what is counted: an instruction counter outside the processor stops its watch here. */
void haptable_port_count_begin(void);
void haptable_port_count_end(void);

#endif
