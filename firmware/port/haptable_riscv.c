/* SPDX-License-Identifier: MIT
 *
 * rv32imafc: memory at reset, and the machine timer as the tick source (RISC-V Privileged Architecture, 3.2.1).
 */
#include "haptable_port.h"
#include "haptable_semihosting.h"

/* From the linker script. */
extern uint32_t haptable_port_data_begin[];
extern uint32_t haptable_port_data_end[];
extern const uint32_t haptable_port_data_flash[];
extern uint32_t haptable_port_bss_begin[];
extern uint32_t haptable_port_bss_end[];

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

/* Called by haptable_riscv_start.S with a stack and nothing else. */
void haptable_port_begin(void);
void haptable_port_begin(void) {
    const uint32_t* from = haptable_port_data_flash;
    uint32_t* to;
    for (to = haptable_port_data_begin; to < haptable_port_data_end; ++to) *to = *from++;
    for (to = haptable_port_bss_begin; to < haptable_port_bss_end; ++to) *to = 0;
    haptable_semihosting_exit(haptable_port_main());
}

__attribute__((noinline)) void haptable_port_count_begin(void) { __asm volatile("" ::: "memory"); }
__attribute__((noinline)) void haptable_port_count_end(void) { __asm volatile("" ::: "memory"); }
