/* SPDX-License-Identifier: MIT
 *
 * The contacts of two fingers: both at once where both are there, or the one that is, as in a scene with one
 */
#include "haptable_scene.h"

void haptable_init_two(const struct haptable_scene* scene, void* state) {
    haptable_pair_init(scene->pair, (struct haptable_pair*)state);
}

void haptable_contacts_of_two(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                              const float x_m[][3], uint32_t now_us, struct haptable_output out[]) {
    struct haptable_pair* pair = (struct haptable_pair*)state;
    const int finger = in[0].is_there ? 0 : 1;
    if (in[0].is_there && in[1].is_there)
        haptable_pair_step(scene->pair, pair, x_m[0], x_m[1], now_us, out);
    else if (in[finger].is_there)
        haptable_pair_step_one(scene->pair, pair, finger, x_m[finger], now_us, &out[finger]);
}
