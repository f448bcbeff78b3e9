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

static HAPTABLE_MODEL_STATE state; /* the interrupt's alone, once it runs */
static struct haptable_input in[HAPTABLE_MODEL_FINGERS];
static struct haptable_output out[HAPTABLE_MODEL_FINGERS];

void TIMER0_IRQ_0_Handler(void);
void TIMER0_IRQ_0_Handler(void) {
    TIMER0->INTR = 1u;                    /* alarm 0's, by writing it */
    TIMER0->ALARM[0] += HAPTABLE_TICK_US; /* of the last alarm, not of now: no drift */
    in[0].is_there = 1;
    if (device_read(in[0].finger_m))
        haptable_step(&HAPTABLE_MODEL_SCENE, &state, in, TIMER0->TIMERAWL, out);
    else if (!haptable_watch(&HAPTABLE_MODEL_SCENE, &state, TIMER0->TIMERAWL, out))
        return; /* in time still: the last force stays */
    device_write(out[0].force_n);
}

int main(void) {
    SCB_CPACR |= 0xFu << 20; /* the floating-point unit */
    haptable_init(&HAPTABLE_MODEL_SCENE, &state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
    TIMER0->INTE = 1u;
    NVIC_ISER0 = 1u << TIMER0_IRQ_0_IRQn;
    TIMER0->ALARM[0] = TIMER0->TIMERAWL + HAPTABLE_TICK_US; /* arms it */
    for (;;) {
    }
}
