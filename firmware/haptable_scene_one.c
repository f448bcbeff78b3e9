/* SPDX-License-Identifier: MIT
 *
 * The contact of one finger
 */
#include "haptable_scene.h"

void haptable_init_one(const struct haptable_scene* scene, void* state) {
    (void)scene;
    haptable_servo_begin(haptable_scene_servo(state, 0));
}

void haptable_contact_of_one(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                             const float x_m[][3], uint32_t now_us, struct haptable_output out[]) {
    if (in[0].is_there) haptable_servo_step(scene->model, haptable_scene_servo(state, 0), x_m[0], now_us, &out[0]);
}

/* As haptable_step_held, in few instructions: a tick of the paper's mode takes 800. */
void haptable_step_one(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                       uint32_t now_us, struct haptable_output out[]) {
    struct haptable_servo* servo = haptable_scene_servo(state, 0);
    const uint32_t known_us = in[0].is_there ? now_us : servo->position_us + HAPTABLE_SILENCE_US;
    if (known_us - servo->position_us >= HAPTABLE_SILENCE_US) (void)haptable_servo_watch(servo, known_us, &out[0]);
    if (!in[0].is_there) return;
    servo->pressed = in[0].buttons & ~servo->buttons;
    servo->buttons = in[0].buttons;
    haptable_servo_step(scene->model, servo, in[0].finger_m, now_us, &out[0]);
}
