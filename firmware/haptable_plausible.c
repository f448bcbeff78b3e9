/* SPDX-License-Identifier: MIT
 *
 * |x_k - x_k-1| <= max_motion_m (t_k - t_k-1) / tick
 */
#include "haptable_model.h"
#include "haptable_safety.h"
#include "haptable_vector.h"

/* Ticks between two positions: 1 or more, and no more than silence lasts. */
static float ticks_in(uint32_t elapsed_us) {
    if (elapsed_us < HAPTABLE_TICK_US) elapsed_us = HAPTABLE_TICK_US;
    if (elapsed_us > HAPTABLE_SILENCE_US) elapsed_us = HAPTABLE_SILENCE_US;
    return (float)elapsed_us * (1.0f / (float)HAPTABLE_TICK_US);
}

static void distrust(struct haptable_servo* servo) {
    ++servo->counters.implausible;
    servo->wait_ticks = HAPTABLE_GOOD_TICKS;
    servo->distrust_ticks = (uint16_t)(servo->distrust_ticks + HAPTABLE_DISTRUST_TICKS);
    if (servo->distrust_ticks <= HAPTABLE_DISTRUST_LIMIT) return;
    servo->distrust_ticks = HAPTABLE_DISTRUST_LIMIT;
    haptable_fault(servo, HAPTABLE_FAULT_POSITIONS);
}

/* See haptable_plausible_motion, where the motion is not small or one before was not believed. */
static int judge(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                 float motion2, uint32_t elapsed_us) {
    const float most_m = model->max_motion_m * ticks_in(elapsed_us);
    const int is_known = servo->finger_known || servo->wait_ticks > 0;
    if (is_known && motion2 > most_m * most_m) {
        distrust(servo);
    } else {
        if (servo->distrust_ticks > 0) --servo->distrust_ticks;
        if (servo->wait_ticks == 0) return 1;
        --servo->wait_ticks;
    }
    vec_copy(finger_m, servo->finger_m); /* the next one is to be near this one, whether it was true or not */
    return 0;
}

int haptable_plausible_motion(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                              uint32_t elapsed_us) {
    float motion[3];
    vec_sub(finger_m, servo->finger_m, motion);
    const float motion2 = vec_length2(motion);
    if (motion2 <= model->max_motion_m * model->max_motion_m && servo->distrust_ticks == 0) return 1; /* most ticks */
    return judge(model, servo, finger_m, motion2, elapsed_us);
}
