/* SPDX-License-Identifier: MIT
 *
 * A tool on a soft object at 1 kHz, from a loop that polls. Replace the two functions of the device by yours.
 */
#include "haptable_port.h"
#include "haptable_scene.h"
#include "model.h"

/* Your encoders and your motors. Here: the handle is 2 mm deep in the first vertex, its axes are the world's. */
static int device_read(float handle_m[3], float turn[4]) {
    int axis;
    for (axis = 0; axis < 3; ++axis) {
        handle_m[axis] = HAPTABLE_MODEL.vertex_m[0][axis];
        turn[1 + axis] = 0.0f;
    }
    handle_m[2] -= 0.002f;
    turn[0] = 1.0f;
    return 1;
}

static volatile float motor_n[3], motor_n_m[3];

static void device_write(const float force_n[3], const float torque_n_m[3]) {
    int axis;
    for (axis = 0; axis < 3; ++axis) {
        motor_n[axis] = force_n[axis];
        motor_n_m[axis] = torque_n_m[axis];
    }
}

int haptable_port_main(void) {
    static HAPTABLE_MODEL_STATE state;
    static struct haptable_tool_input in;
    static struct haptable_tool_output out;
    uint32_t next_us;
    haptable_port_init();
    haptable_init(&HAPTABLE_MODEL_SCENE, &state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
    next_us = haptable_port_now_us();
    for (;;) {
        haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_BYTES);
        while ((int32_t)(haptable_port_now_us() - next_us) < 0) {
        }
        next_us += HAPTABLE_TICK_US;
        in.hand.is_there = (uint8_t)device_read(in.hand.finger_m, in.turn);
        haptable_step(&HAPTABLE_MODEL_SCENE, &state, &in.hand, haptable_port_now_us(), &out.hand);
        device_write(out.hand.force_n, out.torque_n_m);
    }
}
