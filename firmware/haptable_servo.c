/* SPDX-License-Identifier: MIT
 *
 * finger -> checked -> god-object -> force -> checked -> limited -> out
 *
 * States and their transitions: docs/SAFETY.md. What lowers a force acts at once; what raises one are the body, tick by
 * tick, and the gain of a ramp.
 */
#include "haptable_tick.h"

void haptable_servo_init(struct haptable_servo* servo) {
    static const struct haptable_servo none = {.state = HAPTABLE_SILENT};
    *servo = none;
    haptable_servo_begin(servo);
}

void haptable_servo_begin(struct haptable_servo* servo) {
    servo->contact.patch = HAPTABLE_NONE;
    servo->slide_patch = HAPTABLE_NONE;
    servo->gain = 1.0f;
}

void haptable_servo_buttons(struct haptable_servo* servo, uint32_t buttons) {
    servo->pressed = buttons & ~servo->buttons;
    servo->buttons = buttons;
}

void haptable_servo_step(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                         uint32_t now_us, struct haptable_output* out) {
    float motion_m[3];
    if (!begin_tick(model, servo, finger_m, now_us, out)) return;
    move(model, servo, finger_m, motion_m);
    finish_tick(model, servo, motion_m, out);
}

int haptable_servo_watch(struct haptable_servo* servo, uint32_t now_us, struct haptable_output* out) {
    const int was_silent = servo->state == HAPTABLE_SILENT;
    if (!was_silent && now_us - servo->position_us < HAPTABLE_SILENCE_US) return 0;
    if (!was_silent) ++servo->counters.silences;
    give_nothing(servo, HAPTABLE_SILENT, out);
    return 1;
}
