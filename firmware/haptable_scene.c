/* SPDX-License-Identifier: MIT
 *
 * in -> who is there -> contacts, or what moves under them -> out
 */
#include "haptable_scene.h"

#include "haptable_vector.h"

void haptable_scene_init(const struct haptable_scene* scene, void* state) {
    unsigned char* byte = (unsigned char*)state;
    uint32_t i;
    for (i = 0; i < scene->bytes; ++i) byte[i] = 0;
    scene->init(scene, state);
    if (scene->rigid) scene->rigid->init(scene->body, haptable_scene_body(scene, state));
    if (scene->ringing) scene->ringing->init(haptable_scene_modes(scene, state));
}

/* As after silence. */
static void release(struct haptable_servo* servo, struct haptable_output* out) {
    (void)haptable_watch(servo, servo->position_us + HAPTABLE_SILENCE_US, out);
}

void haptable_scene_begin(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                          uint32_t now_us, struct haptable_output out[]) {
    int finger;
    for (finger = 0; finger < haptable_scene_fingers(scene); ++finger) {
        struct haptable_servo* servo = haptable_scene_servo(state, finger);
        if (in[finger].is_there) {
            (void)haptable_watch(servo, now_us, &out[finger]);
            haptable_buttons(servo, in[finger].buttons);
        } else {
            release(servo, &out[finger]);
        }
    }
}

void haptable_scene_step(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                         uint32_t now_us, struct haptable_output out[]) {
    scene->step(scene, state, in, now_us, out);
}

void haptable_step_held(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                        uint32_t now_us, struct haptable_output out[]) {
    float x_m[HAPTABLE_FINGERS][3];
    int finger;
    haptable_scene_begin(scene, state, in, now_us, out);
    for (finger = 0; finger < haptable_scene_fingers(scene); ++finger) vec_copy(in[finger].finger_m, x_m[finger]);
    scene->contacts(scene, state, in, x_m, now_us, out);
}

unsigned haptable_scene_watch(const struct haptable_scene* scene, void* state, uint32_t now_us,
                              struct haptable_output out[]) {
    unsigned silent = 0;
    int finger;
    for (finger = 0; finger < haptable_scene_fingers(scene); ++finger)
        if (haptable_watch(haptable_scene_servo(state, finger), now_us, &out[finger])) silent |= 1u << finger;
    return silent;
}

void haptable_scene_check(const struct haptable_scene* scene, void* state, uint32_t bytes) {
    scene->check(scene, state, bytes);
}
