/* SPDX-License-Identifier: MIT
 *
 * x_k = sum_l w_l C_kl,   C_lk = C_kl^T: the blocks of all pairs k >= l stand in a row by k
 */
#include "haptable_pair_terms.h"

static void add_transposed(float w, const float x[9], float out[9]) {
    out[0] += w * x[0];
    out[1] += w * x[3];
    out[2] += w * x[6];
    out[3] += w * x[1];
    out[4] += w * x[4];
    out[5] += w * x[7];
    out[6] += w * x[2];
    out[7] += w * x[5];
    out[8] += w * x[8];
}

/* One control and all of the other's place. */
static void add_row(const struct haptable_pair_view* view, uint32_t k, int count, float out[9]) {
    const float(*block)[9] = view->tables->block;
    const float(*row)[9] = &block[k * (k + 1u) / 2u];
    int j;
    for (j = 0; j < count; ++j) {
        const uint32_t l = view->place.control[j];
        const float w = view->place.weight[j];
        if (l == HAPTABLE_NONE) continue;
        if (k >= l)
            mat_add(w, row[l], out);
        else
            add_transposed(w, block[l * (l + 1u) / 2u + k], out);
    }
}

void haptable_pair_cross_exact(const struct haptable_pair_view* view, uint16_t patch, float (*x)[9]) {
    const int count = pair_count(view->tables->law);
    uint16_t control[HAPTABLE_PAIR_CONTROLS];
    int i;
    haptable_pair_controls(view->tables, patch, control);
    for (i = 0; i < count; ++i) {
        float sum[9];
        vec_zero(&sum[0]);
        vec_zero(&sum[3]);
        vec_zero(&sum[6]);
        if (control[i] != HAPTABLE_NONE) add_row(view, control[i], count, sum);
        mat_copy(sum, x[i]);
    }
}

static void put_block(const float (*all)[9], uint16_t k, uint16_t l, float block[9]) {
    int a;
    for (a = 0; a < 9; ++a) block[a] = 0.0f;
    if (k == HAPTABLE_NONE || l == HAPTABLE_NONE) return;
    if (k >= l)
        mat_copy(all[(uint32_t)k * (k + 1u) / 2u + l], block);
    else
        add_transposed(1.0f, all[(uint32_t)l * (l + 1u) / 2u + k], block);
}

void haptable_pair_blocks_exact(const struct haptable_pair_model* tables, uint16_t first, uint16_t second,
                                float (*block)[9]) {
    const int count = pair_count(tables->law);
    uint16_t control[HAPTABLE_FINGERS][HAPTABLE_PAIR_CONTROLS];
    int i;
    int j;
    haptable_pair_controls(tables, first, control[0]);
    haptable_pair_controls(tables, second, control[1]);
    for (i = 0; i < count; ++i)
        for (j = 0; j < count; ++j, ++block) put_block(tables->block, control[0][i], control[1][j], *block);
}
