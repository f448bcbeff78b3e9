/* SPDX-License-Identifier: MIT
 *
 * The servo of @scene@ in an interrupt at 1 kHz on an RP2350's Cortex-M33: TIMER0, alarm 0, in registers. Never run on
 * hardware.
 *
 * Registers are named as the part's header names them. The timer counts microseconds where the start-up code has set
 * the tick generator, as the SDK's does. Device and motors are yours. */
#include "haptable.h"
#include "model.h"

typedef struct {
    volatile uint32_t TIMEHW, TIMELW, TIMEHR, TIMELR, ALARM[4], ARMED, TIMERAWH, TIMERAWL, DBGPAUSE, PAUSE, LOCKED,
        SOURCE, INTR, INTE, INTF, INTS;
} TIMER_Type;
#define TIMER0 ((TIMER_Type*)0x400B0000u)
#define NVIC_ISER0 (*(volatile uint32_t*)0xE000E100u)
#define SCB_CPACR (*(volatile uint32_t*)0xE000ED88u)
#define TIMER0_IRQ_0_IRQn 0

/* Yours: encoders (0 when there is no new position), m; motors, N. */
int device_read(float finger_m[3]);
void device_write(const float force_n[3]);

static struct haptable_servo servo; /* the interrupt's alone, once it runs */

void TIMER0_IRQ_0_Handler(void);
void TIMER0_IRQ_0_Handler(void) {
    struct haptable_output out;
    float finger_m[3];
    TIMER0->INTR = 1u;                    /* alarm 0's, by writing it */
    TIMER0->ALARM[0] += HAPTABLE_TICK_US; /* of the last alarm, not of now: no drift */
    if (device_read(finger_m))
        haptable_step(&HAPTABLE_MODEL, &servo, finger_m, TIMER0->TIMERAWL, &out);
    else if (!haptable_watch(&servo, TIMER0->TIMERAWL, &out))
        return; /* in time still: the last force stays */
    device_write(out.force_n);
}

int main(void) {
    SCB_CPACR |= 0xFu << 20; /* the floating-point unit */
    haptable_init(&servo);
    haptable_check(&HAPTABLE_MODEL, &servo, HAPTABLE_CHECK_ALL);
    TIMER0->INTE = 1u;
    NVIC_ISER0 = 1u << TIMER0_IRQ_0_IRQn;
    TIMER0->ALARM[0] = TIMER0->TIMERAWL + HAPTABLE_TICK_US; /* arms it */
    for (;;) {
    }
}
