/* SPDX-License-Identifier: MIT
 *
 * rv32imafc: memory at reset, and the machine timer as the tick source (RISC-V Privileged Architecture, 3.2.1).
 */
#include "port.h"
#include "semihosting.h"

/* From the linker script. */
extern uint32_t port_data_begin[];
extern uint32_t port_data_end[];
extern const uint32_t port_data_flash[];
extern uint32_t port_bss_begin[];
extern uint32_t port_bss_end[];

#ifndef PORT_MTIME
#define PORT_MTIME 0x0200BFF8u /* of QEMU's virt board and SiFive's CLINT; set it to your part's */
#endif
#ifndef PORT_CLOCK_HZ
#define PORT_CLOCK_HZ 10000000u /* of that timer */
#endif

static uint32_t begin_us;

/* Microseconds of the 64-bit timer, whose high half may step between two reads. */
static uint32_t timer_us(void) {
    const volatile uint32_t* const mtime = (const volatile uint32_t*)PORT_MTIME;
    uint32_t high;
    uint32_t low;
    do {
        high = mtime[1];
        low = mtime[0];
    } while (high != mtime[1]);
    return (uint32_t)((((uint64_t)high << 32) | low) / (PORT_CLOCK_HZ / 1000000u));
}

void port_init(void) { begin_us = timer_us(); }

uint32_t port_now_us(void) { return timer_us() - begin_us; }

/* Called by riscv_start.S with a stack and nothing else. */
void port_begin(void);
void port_begin(void) {
    const uint32_t* from = port_data_flash;
    uint32_t* to;
    for (to = port_data_begin; to < port_data_end; ++to) *to = *from++;
    for (to = port_bss_begin; to < port_bss_end; ++to) *to = 0;
    semihosting_exit(port_main());
}

__attribute__((noinline)) void port_count_begin(void) { __asm volatile("" ::: "memory"); }
__attribute__((noinline)) void port_count_end(void) { __asm volatile("" ::: "memory"); }
