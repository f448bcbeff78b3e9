/* SPDX-License-Identifier: MIT
 *
 * x_k = sum_l w_l C_kl,   C_lk = C_kl^T: the blocks of all pairs k >= l stand in a row by k
 */
#include "haptable_pair_terms.h"

/* x += w C_kl */
static inline void add_block(const float (*all)[9], uint32_t k, uint32_t l, float w, float x[9]) {
    if (k == HAPTABLE_NONE || l == HAPTABLE_NONE) return;
    if (k >= l)
        mat_add(w, all[k * (k + 1u) / 2u + l], x);
    else
        mat_add_transposed(w, all[l * (l + 1u) / 2u + k], x);
}

void haptable_pair_cross_exact(const struct haptable_pair_view* view, uint16_t patch, float (*x)[9]) {
    const int count = pair_count(view->tables->law);
    uint16_t control[HAPTABLE_FINGERS][HAPTABLE_PAIR_CONTROLS];
    haptable_pair_controls(view->tables, patch, control[0]);
    haptable_pair_controls(view->tables, view->place.patch, control[1]);
    for (int i = 0; i < count; ++i) {
        float sum[9] = {0.0f}; /* in registers */
        for (int j = 0; j < count; ++j)
            add_block(view->tables->block, control[0][i], control[1][j], view->place.weight[j], sum);
        mat_copy(sum, x[i]);
    }
}

void haptable_pair_blocks_exact(const struct haptable_pair_model* tables, uint16_t first, uint16_t second,
                                float (*block)[9]) {
    const int count = pair_count(tables->law);
    uint16_t control[HAPTABLE_FINGERS][HAPTABLE_PAIR_CONTROLS];
    haptable_pair_controls(tables, first, control[0]);
    haptable_pair_controls(tables, second, control[1]);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j, ++block) {
            float one[9] = {0.0f};
            add_block(tables->block, control[0][i], control[1][j], 1.0f, one);
            mat_copy(one, *block);
        }
}
