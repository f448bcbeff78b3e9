/* SPDX-License-Identifier: MIT
 *
 * The line as a 16550 UART, polled: QEMU's RISC-V virt board. HAPTABLE_PORT_UART is its address (firmware.mk).
 * Registers: National Semiconductor, PC16550D, section 8.
 */
#include "haptable_port.h"

#define REGISTER(offset) (*(volatile uint8_t*)(HAPTABLE_PORT_UART + (offset)))
#define DATA REGISTER(0)
#define FIFO_CONTROL REGISTER(2)
#define LINE_CONTROL REGISTER(3)
#define LINE_STATUS REGISTER(5)

#define FIFO_ON 7u /* and both emptied */
#define EIGHT_BITS 3u
#define STATUS_RX 0x01u
#define STATUS_TX_EMPTY 0x20u

int haptable_serial_open(void) {
    LINE_CONTROL = EIGHT_BITS;
    FIFO_CONTROL = FIFO_ON;
    return 0;
}

int haptable_serial_read(uint8_t* byte) {
    while ((LINE_STATUS & STATUS_RX) == 0u) {
    }
    *byte = DATA;
    return 1;
}

void haptable_serial_write(const uint8_t* bytes, uint32_t count) {
    uint32_t i;
    for (i = 0; i < count; ++i) {
        while ((LINE_STATUS & STATUS_TX_EMPTY) == 0u) {
        }
        DATA = bytes[i];
    }
}
