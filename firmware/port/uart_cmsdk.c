/* SPDX-License-Identifier: MIT
 *
 * The line as the UART of Arm's CMSDK, polled: QEMU's mps2 boards. PORT_UART is its address (firmware.mk).
 * Registers: Arm, Cortex-M System Design Kit Technical Reference Manual (DDI 0479), 4.3.
 */
#include "line.h"

#define REGISTER(offset) (*(volatile uint32_t*)(PORT_UART + (offset)))
#define DATA REGISTER(0x00u)
#define STATE REGISTER(0x04u)
#define CTRL REGISTER(0x08u)
#define BAUDDIV REGISTER(0x10u)

#define STATE_TX_FULL 1u
#define STATE_RX_FULL 2u
#define CTRL_TX_RX 3u

int line_open(void) {
    BAUDDIV = 25u; /* 25 MHz: 1 Mbaud; QEMU does not look */
    CTRL = CTRL_TX_RX;
    return 0;
}

int line_read(uint8_t* byte) {
    while ((STATE & STATE_RX_FULL) == 0u) {
    }
    *byte = (uint8_t)DATA;
    return 1;
}

void line_write(const uint8_t* bytes, uint32_t count) {
    uint32_t i;
    for (i = 0; i < count; ++i) {
        while ((STATE & STATE_TX_FULL) != 0u) {
        }
        DATA = bytes[i];
    }
}
