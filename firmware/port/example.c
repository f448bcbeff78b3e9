/* SPDX-License-Identifier: MIT
 *
 * A soft object at 1 kHz, from a loop that polls. Replace the two functions of the device by yours.
 */
#include "haptable_port.h"
#include "haptable_scene.h"
#include "model.h"

/* Your encoders and your motors. Here: a finger that is pressed 2 mm deep into the first vertex. */
static int device_read(int finger, float finger_m[3]) {
    (void)finger;
    finger_m[0] = HAPTABLE_MODEL.vertex_m[0][0];
    finger_m[1] = HAPTABLE_MODEL.vertex_m[0][1];
    finger_m[2] = HAPTABLE_MODEL.vertex_m[0][2] - 0.002f;
    return 1;
}

static volatile float motor_n[HAPTABLE_MODEL_FINGERS][3];

static void device_write(int finger, const float force_n[3]) {
    int axis;
    for (axis = 0; axis < 3; ++axis) motor_n[finger][axis] = force_n[axis];
}

int haptable_port_main(void) {
    static HAPTABLE_MODEL_STATE state;
    static struct haptable_input in[HAPTABLE_MODEL_FINGERS];
    static struct haptable_output out[HAPTABLE_MODEL_FINGERS];
    uint32_t next_us;
    haptable_port_init();
    haptable_init(&HAPTABLE_MODEL_SCENE, &state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
    next_us = haptable_port_now_us();
    for (;;) {
        int finger;
        haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_BYTES);
        while ((int32_t)(haptable_port_now_us() - next_us) < 0) {
        }
        next_us += HAPTABLE_TICK_US;
        for (finger = 0; finger < HAPTABLE_MODEL_FINGERS; ++finger)
            in[finger].is_there = (uint8_t)device_read(finger, in[finger].finger_m);
        haptable_step(&HAPTABLE_MODEL_SCENE, &state, in, haptable_port_now_us(), out);
        for (finger = 0; finger < HAPTABLE_MODEL_FINGERS; ++finger) device_write(finger, out[finger].force_n);
    }
}
