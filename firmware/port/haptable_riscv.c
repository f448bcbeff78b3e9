/* SPDX-License-Identifier: MIT
 *
 * rv32imafc: the machine timer as the tick source (RISC-V Privileged Architecture, 3.2.1).
 */
#include "haptable_port.h"

#ifndef HAPTABLE_PORT_MTIME
#define HAPTABLE_PORT_MTIME 0x0200BFF8u /* of QEMU's virt board and SiFive's CLINT; set it to your part's */
#endif
#ifndef HAPTABLE_PORT_CLOCK_HZ
#define HAPTABLE_PORT_CLOCK_HZ 10000000u /* of that timer */
#endif

static uint32_t begin_us;

/* Microseconds of the 64-bit timer, whose high half may step between two reads. */
static uint32_t timer_us(void) {
    const volatile uint32_t* const mtime = (const volatile uint32_t*)HAPTABLE_PORT_MTIME;
    uint32_t high;
    uint32_t low;
    do {
        high = mtime[1];
        low = mtime[0];
    } while (high != mtime[1]);
    return (uint32_t)((((uint64_t)high << 32) | low) / (HAPTABLE_PORT_CLOCK_HZ / 1000000u));
}

void haptable_port_init(void) { begin_us = timer_us(); }

uint32_t haptable_port_now_us(void) { return timer_us() - begin_us; }
