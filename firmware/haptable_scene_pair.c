/* SPDX-License-Identifier: MIT
 *
 * The contacts of two fingers: both at once where both are there, or the one that is, as in a scene with one
 */
#include "haptable_scene.h"

void haptable_init_two(const struct haptable_scene* scene, void* state) {
    haptable_pair_init(scene->pair, (struct haptable_pair*)state);
}

void haptable_contacts_of_two(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                              float x_m[][3], uint32_t now_us, struct haptable_output out[]) {
    struct haptable_pair* pair = (struct haptable_pair*)state;
    int f;
    if (in[0].is_there && in[1].is_there)
        haptable_pair_step(scene->pair, pair, x_m[0], x_m[1], now_us, out);
    else if (in[0].is_there || in[1].is_there)
        haptable_pair_step_one(scene->pair, pair, in[0].is_there ? 0 : 1, x_m[in[0].is_there ? 0 : 1], now_us,
                               &out[in[0].is_there ? 0 : 1]);
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        const float* raised_m = pair->view[f].raised_m;
        x_m[f][0] += raised_m[0];
        x_m[f][1] += raised_m[1];
        x_m[f][2] += raised_m[2];
    }
}

void haptable_check_of_two(const struct haptable_scene* scene, void* state, uint32_t bytes) {
    haptable_pair_check(scene->pair, (struct haptable_pair*)state, bytes);
}
