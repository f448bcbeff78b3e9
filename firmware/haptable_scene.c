/* SPDX-License-Identifier: MIT
 *
 * in -> who is there -> contacts, or what moves under them -> out
 */
#include "haptable_scene.h"

#include "haptable.h"
#include "haptable_vector.h"

void haptable_init(const struct haptable_scene* scene, void* state) {
    unsigned char* byte = (unsigned char*)state;
    for (uint32_t i = 0; i < scene->bytes; ++i) byte[i] = 0;
    scene->init(scene, state);
    if (scene->rigid) scene->rigid->init(scene->body, haptable_scene_body(scene, state));
    if (scene->ringing) scene->ringing->init(haptable_scene_modes(scene, state));
}

/* As after silence. */
static void release(struct haptable_servo* servo, struct haptable_output* out) {
    (void)haptable_servo_watch(servo, servo->position_us + HAPTABLE_SILENCE_US, out);
}

void haptable_scene_begin(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                          uint32_t now_us, struct haptable_output out[]) {
    for (int finger = 0; finger < haptable_scene_fingers(scene); ++finger) {
        struct haptable_servo* servo = haptable_scene_servo(state, finger);
        if (in[finger].is_there) {
            (void)haptable_servo_watch(servo, now_us, &out[finger]);
            haptable_servo_buttons(servo, in[finger].buttons);
        } else {
            release(servo, &out[finger]);
        }
    }
}

void haptable_step(const struct haptable_scene* scene, void* state, const struct haptable_input in[], uint32_t now_us,
                   struct haptable_output out[]) {
    scene->step(scene, state, in, now_us, out);
}

void haptable_step_held(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                        uint32_t now_us, struct haptable_output out[]) {
    float x_m[HAPTABLE_FINGERS][3];
    haptable_scene_begin(scene, state, in, now_us, out);
    for (int finger = 0; finger < haptable_scene_fingers(scene); ++finger) vec_copy(in[finger].finger_m, x_m[finger]);
    scene->contacts(scene, state, in, (const float(*)[3])x_m, now_us, out);
}

unsigned haptable_watch(const struct haptable_scene* scene, void* state, uint32_t now_us,
                        struct haptable_output out[]) {
    unsigned silent = 0;
    for (int finger = 0; finger < haptable_scene_fingers(scene); ++finger)
        if (haptable_servo_watch(haptable_scene_servo(state, finger), now_us, &out[finger])) silent |= 1u << finger;
    return silent;
}

void haptable_check(const struct haptable_scene* scene, void* state, uint32_t bytes) {
    if (scene->model->check) scene->model->check(scene, haptable_scene_servo(state, 0), bytes);
}

const struct haptable_counters* haptable_counters_of(const void* state, int finger) {
    return &((const struct haptable_servo*)state + finger)->counters;
}

/* The parts of a state that is only read. */
static const void* part_at(const void* state, uint32_t byte) { return (const unsigned char*)state + byte; }

void haptable_pose_of(const struct haptable_scene* scene, const void* state, struct haptable_body_pose* pose) {
    const struct haptable_body_state* body = (const struct haptable_body_state*)part_at(state, scene->body_at);
    for (int i = 0; i < 4; ++i) pose->turn[i] = body->turn[i];
    vec_copy(body->position_m, pose->position_m);
    vec_copy(body->velocity_m_per_s, pose->velocity_m_per_s);
    vec_copy(body->spin_rad_per_s, pose->spin_rad_per_s);
    pose->on_floor = body->on_floor;
}

const float* haptable_swing_of(const struct haptable_scene* scene, const void* state) {
    return ((const struct haptable_modes_state*)part_at(state, scene->modes_at))->q;
}
