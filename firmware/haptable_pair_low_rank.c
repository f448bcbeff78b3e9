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

/* x += w E_kl, where the pair is near. */
static void add_near(const struct haptable_pair_model* tables, float w, uint16_t k, uint16_t l, float x[9]) {
    const float step = w * tables->near_step;
    const int16_t* block = k >= l ? near_block(tables, k, l) : near_block(tables, l, k);
    int a;
    int b;
    if (!block) return;
    for (a = 0; a < 3; ++a)
        for (b = 0; b < 3; ++b) x[3 * a + b] += step * (float)(k >= l ? block[3 * a + b] : block[3 * b + a]);
}

static void add_near_of_place(const struct haptable_pair_view* view, uint16_t k, float x[9]) {
    int j;
    for (j = 0; j < view->tables->law->controls; ++j) {
        const uint16_t l = view->place.control[j];
        const float w = view->place.weight[j];
        if (l != HAPTABLE_NONE && w != 0.0f) add_near(view->tables, w, k, l, x);
    }
}

static void put_block(const struct haptable_pair_model* tables, uint16_t k, uint16_t l, float block[9]) {
    int a;
    int r;
    for (a = 0; a < 9; ++a) block[a] = 0.0f;
    if (k == HAPTABLE_NONE || l == HAPTABLE_NONE) return;
    for (r = 0; r < tables->rank; ++r) {
        const int16_t* one = tables->column[(uint32_t)k * tables->rank + (uint32_t)r];
        float two[3] = {0.0f, 0.0f, 0.0f};
        add_steps(tables->column_step, tables->column[(uint32_t)l * tables->rank + (uint32_t)r], two);
        for (a = 0; a < 3; ++a) vec_add_scaled(tables->column_step * (float)one[a], two, &block[3 * a]);
    }
    add_near(tables, 1.0f, k, l, block);
}

void haptable_pair_blocks_low_rank(const struct haptable_pair_model* tables, const uint16_t* first,
                                   const uint16_t* second, int count, float (*block)[9]) {
    int i;
    int j;
    for (i = 0; i < count; ++i)
        for (j = 0; j < count; ++j, ++block) put_block(tables, first[i], second[j], *block);
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
        add_near_of_place(view, control[i], x[i]);
    }
}
