/* SPDX-License-Identifier: MIT
 *
 * What an image needs of its machine, and nothing more: time, a way to stop, and marks for an instruction counter.
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

/* Empty functions around what is counted: an instruction counter outside the processor stops its watch here. */
void haptable_port_count_begin(void);
void haptable_port_count_end(void);

#endif
