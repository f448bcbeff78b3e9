/* SPDX-License-Identifier: MIT
 *
 * x_k = sum_r Phi_kr z_r^T + sum of near w_l E_kl,   z_r = sum_l w_l Phi_lr
 *
 * Phi Phi^T is never more than C (Nystroem): what it lacks of C_kl is kept for near pairs as E_kl, for the others not.
 */
#include "haptable_pair_terms.h"

static void add_steps(float step, const int16_t steps[3], float out[3]) {
    out[0] += step * (float)steps[0];
    out[1] += step * (float)steps[1];
    out[2] += step * (float)steps[2];
}

void haptable_pair_far_low_rank(struct haptable_pair_view* view) {
    const struct haptable_pair_model* tables = view->tables;
    int j;
    int r;
    for (r = 0; r < tables->rank; ++r) vec_zero(view->far[r]);
    for (j = 0; j < tables->law->controls; ++j) {
        const uint16_t l = view->place.control[j];
        const float w = view->place.weight[j];
        if (l == HAPTABLE_NONE || w == 0.0f) continue;
        for (r = 0; r < tables->rank; ++r)
            add_steps(w * tables->column_step, tables->column[(uint32_t)l * tables->rank + (uint32_t)r], view->far[r]);
    }
}

/* Where the pair's block stands, k >= l; NULL: the pair is far. */
static const int16_t* near_block(const struct haptable_pair_model* tables, uint16_t k, uint16_t l) {
    uint32_t low = tables->near_begin[k];
    uint32_t high = tables->near_begin[k + 1u];
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (tables->near[middle] < l)
            low = middle + 1;
        else
            high = middle;
    }
    return low < tables->near_begin[k + 1u] && tables->near[low] == l ? tables->near_block[low] : 0;
}

static void add_near(const struct haptable_pair_view* view, uint16_t k, float x[9]) {
    int j;
    for (j = 0; j < view->tables->law->controls; ++j) {
        const uint16_t l = view->place.control[j];
        const float w = view->place.weight[j];
        const float step = w * view->tables->near_step;
        const int16_t* block;
        int a;
        int b;
        if (l == HAPTABLE_NONE || w == 0.0f) continue;
        block = k >= l ? near_block(view->tables, k, l) : near_block(view->tables, l, k);
        if (!block) continue;
        for (a = 0; a < 3; ++a)
            for (b = 0; b < 3; ++b) x[3 * a + b] += step * (float)(k >= l ? block[3 * a + b] : block[3 * b + a]);
    }
}

void haptable_pair_cross_low_rank(const struct haptable_pair_view* view, const uint16_t* control, int count,
                                  float (*x)[9]) {
    const struct haptable_pair_model* tables = view->tables;
    int i;
    int a;
    int r;
    for (i = 0; i < count; ++i) {
        for (a = 0; a < 9; ++a) x[i][a] = 0.0f;
        if (control[i] == HAPTABLE_NONE) continue;
        for (r = 0; r < tables->rank; ++r) {
            const int16_t* column = tables->column[(uint32_t)control[i] * tables->rank + (uint32_t)r];
            float* row = x[i];
            for (a = 0; a < 3; ++a, row += 3) vec_add_scaled(tables->column_step * (float)column[a], view->far[r], row);
        }
        add_near(view, control[i], x[i]);
    }
}
