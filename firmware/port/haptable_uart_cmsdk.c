/* SPDX-License-Identifier: MIT
 *
 * The line as the UART of Arm's CMSDK: QEMU's mps2 boards. HAPTABLE_PORT_UART is its address, HAPTABLE_PORT_UART_IRQ
 * its receiving interrupt, the next one the sending one (firmware.mk). Between bytes the processor sleeps: a pending
 * interrupt wakes it though interrupts are masked, so that there is no handler. Under QEMU, a processor that polls
 * instead keeps the emulated UART from its lock. Registers: Arm, Cortex-M System Design Kit Technical Reference Manual
 * (DDI 0479), 4.3; Armv7-M Architecture Reference Manual (DDI 0403), B3.4.
 */
#include "haptable_port.h"

#define REGISTER(offset) (*(volatile uint32_t*)(HAPTABLE_PORT_UART + (offset)))
#define DATA REGISTER(0x00u)
#define STATE REGISTER(0x04u)
#define CTRL REGISTER(0x08u)
#define INTERRUPT REGISTER(0x0Cu) /* what is pending; a 1 clears it */
#define BAUDDIV REGISTER(0x10u)

#define NVIC(offset) (*(volatile uint32_t*)(0xE000E000u + (offset) + 4u * (HAPTABLE_PORT_UART_IRQ / 32u)))
#define NVIC_ENABLE NVIC(0x100u)
#define NVIC_CLEAR NVIC(0x280u)
#define NVIC_BITS (3u << (HAPTABLE_PORT_UART_IRQ % 32u))

#define STATE_TX_FULL 1u
#define STATE_RX_FULL 2u
#define CTRL_TX_RX 3u
#define CTRL_RX_INTERRUPT 8u
#define INTERRUPT_RX 2u

int haptable_serial_open(void) {
    BAUDDIV = 25u; /* 25 MHz: 1 Mbaud; QEMU does not look */
    CTRL = CTRL_TX_RX | CTRL_RX_INTERRUPT;
    __asm__ volatile("cpsid i" ::: "memory");
    NVIC_ENABLE = NVIC_BITS;
    return 0;
}

int haptable_serial_read(uint8_t* byte) {
    while ((STATE & STATE_RX_FULL) == 0u) { /* a byte that comes here leaves its interrupt pending: no sleep */
        __asm__ volatile("wfi" ::: "memory");
        INTERRUPT = INTERRUPT_RX;
        NVIC_CLEAR = NVIC_BITS;
    }
    *byte = (uint8_t)DATA;
    return 1;
}

void haptable_serial_write(const uint8_t* bytes, uint32_t count) {
    uint32_t i;
    for (i = 0; i < count; ++i) {
        while ((STATE & STATE_TX_FULL) != 0u) {
        }
        DATA = bytes[i];
    }
}
