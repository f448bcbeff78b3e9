// SPDX-License-Identifier: MIT
// Polls a device every millisecond. device_read and device_write are yours. Never run on hardware.
#include <haptable.h>
#include <model.h>

static HAPTABLE_MODEL_STATE state;
static haptable_input in[HAPTABLE_MODEL_FINGERS];
static haptable_output out[HAPTABLE_MODEL_FINGERS];
static uint32_t next_us;

static int device_read(float finger_m[3]) {
    finger_m[0] = finger_m[1] = finger_m[2] = 0.0f;  // m, from your encoders; return 0 when there is no new position
    return 1;
}

static void device_write(const float force_n[3]) { (void)force_n; }  // N, to your motors

void setup() {
    haptable_init(&HAPTABLE_MODEL_SCENE, &state);
    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
    next_us = micros();
}

void loop() {
    if ((int32_t)(micros() - next_us) < 0) return;
    next_us += HAPTABLE_TICK_US;
    in[0].is_there = 1;
    if (device_read(in[0].finger_m))
        haptable_step(&HAPTABLE_MODEL_SCENE, &state, in, micros(), out);
    else if (!haptable_watch(&HAPTABLE_MODEL_SCENE, &state, micros(), out))
        return;  // in time still: the last force stays
    device_write(out[0].force_n);
}
