/* SPDX-License-Identifier: MIT
 *
 * Cortex-M4F, M7 and M33: vectors, reset, SysTick as the tick source, the semihosting call.
 * Registers: Arm, ARMv7-M (DDI 0403E) and ARMv8-M (DDI 0553) Architecture Reference Manuals, B3.2 and D1.2.
 */
#include "haptable_port.h"
#include "haptable_semihosting.h"

extern uint32_t haptable_port_stack_end[]; /* from the linker script */

#define CPACR (*(volatile uint32_t*)0xE000ED88u)
#define SYST_CSR (*(volatile uint32_t*)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t*)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t*)0xE000E018u)

#ifndef HAPTABLE_PORT_CLOCK_HZ
#define HAPTABLE_PORT_CLOCK_HZ 25000000u /* of SysTick: QEMU's mps2 boards; set it to your part's */
#endif
#define CLOCKS_PER_MS (HAPTABLE_PORT_CLOCK_HZ / 1000u)

static volatile uint32_t port_ms;

static void tick(void) { ++port_ms; }

/* A fault, or an interrupt that nobody has asked for: stop with a status that says so. */
static void stop(void) {
    haptable_semihosting_exit(70);
    for (;;) {
    }
}

static void reset(void) {
    CPACR |= 0xFu << 20; /* the floating-point unit, for all code; before the first floating-point instruction */
    __asm volatile("dsb\n\tisb" ::: "memory");
    haptable_port_begin();
    stop();
}

struct vectors {
    uint32_t* stack_end;
    void (*handler[15])(void); /* reset, 13 faults and system calls, SysTick */
};
extern const struct vectors haptable_port_vectors;
__attribute__((section(".vectors"), used)) const struct vectors haptable_port_vectors = {
    haptable_port_stack_end,
    {reset, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, stop, tick}};

void haptable_port_init(void) {
    SYST_RVR = CLOCKS_PER_MS - 1u;
    SYST_CVR = 0;
    SYST_CSR = 7u; /* on, with interrupt, from the processor's clock */
}

uint32_t haptable_port_now_us(void) {
    uint32_t ms;
    uint32_t left;
    do { /* the interrupt may come between the two */
        ms = port_ms;
        left = SYST_CVR;
    } while (ms != port_ms);
    return ms * 1000u + (CLOCKS_PER_MS - 1u - left) / (CLOCKS_PER_MS / 1000u);
}

uint32_t haptable_semihosting_call(uint32_t operation, const void* block) {
    register uint32_t r0 __asm("r0") = operation;
    register const void* r1 __asm("r1") = block;
    __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}
