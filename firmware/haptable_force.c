/* SPDX-License-Identifier: MIT
 *
 * F <- F min(1, max / |F|)
 */
#include "haptable_force.h"

#include "haptable_vector.h"

int haptable_force_clamp(float max_n, float force_n[3]) {
    const float size2 = vec_length2(force_n);
    if (size2 <= max_n * max_n) return 0;
    vec_scale(max_n * vec_inverse_root(size2), force_n);
    return 1;
}
