/* SPDX-License-Identifier: MIT
 *
 * x_k = sum_l w_l C_kl,   C_lk = C_kl^T: the blocks of all pairs k >= l stand in a row by k
 */
#include "haptable_pair_terms.h"

static void add_transposed(float w, const float x[9], float out[9]) {
    int i;
    int j;
    for (i = 0; i < 3; ++i)
        for (j = 0; j < 3; ++j) out[3 * i + j] += w * x[3 * j + i];
}

void haptable_pair_cross_exact(const struct haptable_pair_view* view, const uint16_t* control, int count,
                               float (*x)[9]) {
    const float(*block)[9] = view->tables->block;
    int i;
    int j;
    for (j = 0; j < count; ++j) {
        const uint32_t l = view->place.control[j];
        const float w = view->place.weight[j];
        if (l == HAPTABLE_NONE || w == 0.0f) continue;
        for (i = 0; i < count; ++i) {
            const uint32_t k = control[i];
            if (k == HAPTABLE_NONE) continue;
            if (k >= l)
                pair_add(w, block[k * (k + 1) / 2 + l], x[i]);
            else
                add_transposed(w, block[l * (l + 1) / 2 + k], x[i]);
        }
    }
}
