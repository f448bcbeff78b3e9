/* SPDX-License-Identifier: MIT
 *
 * The tick of a body that moves, and whose dents are linear
 */
#include "haptable_moving.h"

void haptable_moving(const struct haptable_scene* scene, void* state, const struct haptable_input in[], uint32_t now_us,
                     struct haptable_output out[]) {
    moving(scene, state, 0, in, now_us, out);
}
