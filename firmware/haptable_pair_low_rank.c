/* SPDX-License-Identifier: MIT
 *
 * x_k = sum_r Phi_kr z_r^T + sum of near w_l E_kl,   z_r = sum_l w_l Phi_lr
 *
 * Phi Phi^T is never more than C (Nystroem): what it lacks of C_kl is kept for near pairs as E_kl, for the others not.
 */
#include "haptable_pair_terms.h"

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
            vec_add_scaled(w, tables->column[(uint32_t)l * tables->rank + (uint32_t)r], view->far[r]);
    }
}

/* Where the pair's block stands, k >= l; NULL: the pair is far. */
static const float* near_block(const struct haptable_pair_model* tables, uint16_t k, uint16_t l) {
    uint32_t low = tables->near_begin[k];
    uint32_t high = tables->near_begin[k + 1u];
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (tables->near[middle] < l)
            low = middle + 1;
        else
            high = middle;
    }
    return low < tables->near_begin[k + 1u] && tables->near[low] == l ? tables->block[low] : 0;
}

static void add_near(const struct haptable_pair_view* view, uint16_t k, float x[9]) {
    int j;
    for (j = 0; j < view->tables->law->controls; ++j) {
        const uint16_t l = view->place.control[j];
        const float w = view->place.weight[j];
        const float* block;
        int a;
        int b;
        if (l == HAPTABLE_NONE || w == 0.0f) continue;
        block = k >= l ? near_block(view->tables, k, l) : near_block(view->tables, l, k);
        if (!block) continue;
        for (a = 0; a < 3; ++a)
            for (b = 0; b < 3; ++b) x[3 * a + b] += w * (k >= l ? block[3 * a + b] : block[3 * b + a]);
    }
}

void haptable_pair_cross_low_rank(const struct haptable_pair_view* view, const uint16_t* control, int count,
                                  float (*x)[9]) {
    const struct haptable_pair_model* tables = view->tables;
    int i;
    int a;
    int r;
    for (i = 0; i < count; ++i) {
        if (control[i] == HAPTABLE_NONE) continue;
        for (r = 0; r < tables->rank; ++r) {
            const float* column = tables->column[(uint32_t)control[i] * tables->rank + (uint32_t)r];
            for (a = 0; a < 3; ++a) vec_add_scaled(column[a], view->far[r], &x[i][3 * a]);
        }
        add_near(view, control[i], x[i]);
    }
}
