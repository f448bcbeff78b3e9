/* SPDX-License-Identifier: MIT
 * A finger that goes down into the top of a body, and what it feels: cc touch.c $(pkg-config --cflags --libs haptable)
 */
#include <haptable_library.h>
#include <stdio.h>

int main(int argc, char** argv) {
    struct haptable_object* object = haptable_object_load(argc > 1 ? argv[1] : "build/cube", 0);
    struct haptable_finger* finger = object ? haptable_finger_new(object) : NULL;
    struct haptable_touch touch;
    uint32_t tick;
    if (!finger) {
        fprintf(stderr, "touch: %s\n", haptable_library_error());
        return 1;
    }
    for (tick = 0; tick < 60; ++tick) {
        const float position_m[3] = {0.015f, 0.015f, 0.032f - 1e-4f * (float)tick};
        haptable_finger_step(finger, position_m, 1000 * tick, &touch);
    }
    printf("%s: %.4g N on nodes %d %d %d, %.4g J stored\n", haptable_object_describe(object).name, touch.force_n[2],
           touch.node[0], touch.node[1], touch.node[2], haptable_finger_energy(finger).stored_j);
    haptable_finger_free(finger);
    haptable_object_free(object);
    return 0;
}
