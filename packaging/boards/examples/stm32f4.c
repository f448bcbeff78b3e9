/* SPDX-License-Identifier: MIT
 *
 * The servo of @scene@ in an interrupt at 1 kHz on an STM32F4: TIM2, in registers. Never run on hardware.
 *
 * Registers are named as the part's CMSIS header names them; with that header, leave out the structs below. Clocks as
 * your start-up code sets them: TIM_CLOCK_HZ is what the timers of APB1 get. Device and motors are yours. */
#include "haptable.h"
#include "model.h"

#define TIM_CLOCK_HZ 84000000u

typedef struct {
    volatile uint32_t CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR;
} TIM_TypeDef;
#define TIM2 ((TIM_TypeDef*)0x40000000u)
#define TIM5 ((TIM_TypeDef*)0x40000C00u)
#define RCC_APB1ENR (*(volatile uint32_t*)0x40023840u)
#define RCC_APB1ENR_TIM2EN (1u << 0)
#define RCC_APB1ENR_TIM5EN (1u << 3)
#define NVIC_ISER0 (*(volatile uint32_t*)0xE000E100u)
#define SCB_CPACR (*(volatile uint32_t*)0xE000ED88u)
#define TIM2_IRQn 28

/* Yours: encoders (0 when there is no new position), m; motors, N. */
int device_read(float finger_m[3]);
void device_write(const float force_n[3]);

static HAPTABLE_MODEL_STATE state; /* the interrupt's alone, once it runs */
static struct haptable_input in[HAPTABLE_MODEL_FINGERS];
static struct haptable_output out[HAPTABLE_MODEL_FINGERS];

void TIM2_IRQHandler(void);
void TIM2_IRQHandler(void) {
    TIM2->SR = 0; /* the update's flag */
    in[0].is_there = 1;
    if (device_read(in[0].finger_m))
        haptable_step(&HAPTABLE_MODEL_SCENE, &state, in, TIM5->CNT, out);
    else if (!haptable_watch(&HAPTABLE_MODEL_SCENE, &state, TIM5->CNT, out))
        return; /* in time still: the last force stays */
    device_write(out[0].force_n);
}

int main(void) {
    SCB_CPACR |= 0xFu << 20; /* the floating-point unit */
    haptable_init(&HAPTABLE_MODEL_SCENE, &state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
    RCC_APB1ENR |= RCC_APB1ENR_TIM2EN | RCC_APB1ENR_TIM5EN;
    TIM5->PSC = TIM_CLOCK_HZ / 1000000u - 1u; /* 32 bits that count microseconds */
    TIM5->ARR = 0xFFFFFFFFu;
    TIM5->EGR = 1u; /* takes PSC */
    TIM5->CR1 = 1u;
    TIM2->PSC = TIM_CLOCK_HZ / 1000000u - 1u;
    TIM2->ARR = HAPTABLE_TICK_US - 1u;
    TIM2->EGR = 1u;
    TIM2->SR = 0;
    TIM2->DIER = 1u; /* an interrupt at every update */
    NVIC_ISER0 = 1u << TIM2_IRQn;
    TIM2->CR1 = 1u;
    for (;;) {
    }
}
