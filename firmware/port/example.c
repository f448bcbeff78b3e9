/* SPDX-License-Identifier: MIT
 *
 * The example of firmware/README.md: a soft object at 1 kHz, from a loop that polls. Replace the two functions of the
 * device by yours.
 */
#include "haptable.h"
#include "haptable_port.h"
#include "model.h"

/* Your encoders and your motors. Here: a finger that is pressed 2 mm deep into the first vertex. */
static int device_read(float finger_m[3]) {
    finger_m[0] = HAPTABLE_MODEL.vertex_m[0][0];
    finger_m[1] = HAPTABLE_MODEL.vertex_m[0][1];
    finger_m[2] = HAPTABLE_MODEL.vertex_m[0][2] - 0.002f;
    return 1;
}

static volatile float motor_n[3];

static void device_write(const float force_n[3]) {
    int axis;
    for (axis = 0; axis < 3; ++axis) motor_n[axis] = force_n[axis];
}

int haptable_port_main(void) {
    static struct haptable_servo servo;
    uint32_t next_us;
    haptable_port_init();
    haptable_init(&servo);
    haptable_check(&HAPTABLE_MODEL, &servo, HAPTABLE_CHECK_ALL);
    next_us = haptable_port_now_us();
    for (;;) {
        struct haptable_output out;
        float finger_m[3];
        haptable_check(&HAPTABLE_MODEL, &servo, HAPTABLE_CHECK_BYTES);
        while ((int32_t)(haptable_port_now_us() - next_us) < 0) {
        }
        next_us += HAPTABLE_TICK_US;
        if (device_read(finger_m))
            haptable_step(&HAPTABLE_MODEL, &servo, finger_m, haptable_port_now_us(), &out);
        else if (!haptable_watch(&servo, haptable_port_now_us(), &out))
            continue; /* still in time: the last force stays */
        device_write(out.force_n);
    }
}
