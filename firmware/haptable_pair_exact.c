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

/* C_kl where k >= l, else C_lk. */
static inline const float* block_between(const struct haptable_pair_model* tables, uint32_t k, uint32_t l) {
    const uint32_t high = k >= l ? k : l;
    const uint32_t low = k >= l ? l : k;
    return tables->block[high * (high + 1u) / 2u + low];
}

void haptable_pair_couple_exact(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                                const struct haptable_pair_place* second, float x[9]) {
    const int count = pair_count(tables->law);
    uint16_t control[2][HAPTABLE_PAIR_CONTROLS];
    float sum[2][9] = {{0.0f}}; /* of blocks as they stand, and of transposed ones: no branch on the order */
    haptable_pair_controls(tables, first->patch, control[0]);
    haptable_pair_controls(tables, second->patch, control[1]);
    for (int i = 0; i < count; ++i) {
        const uint32_t k = control[0][i];
        if (k == HAPTABLE_NONE || first->weight[i] == 0.0f) continue;
        for (int j = 0; j < count; ++j) {
            const uint32_t l = control[1][j];
            if (l == HAPTABLE_NONE) continue;
            mat_add(first->weight[i] * second->weight[j], block_between(tables, k, l), sum[k < l]);
        }
    }
    mat_transpose(sum[1]);
    mat_copy(sum[0], x);
    mat_add(1.0f, sum[1], x);
}

void haptable_pair_pull_exact(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                              const struct haptable_pair_place* second, const float v[3], const float w[3],
                              float q[HAPTABLE_PAIR_CONTROLS], float r[HAPTABLE_PAIR_CONTROLS]) {
    const int count = pair_count(tables->law);
    const float* const by[2][2] = {{v, w}, {w, v}}; /* no branch on the order of two controls */
    uint16_t control[2][HAPTABLE_PAIR_CONTROLS];
    haptable_pair_controls(tables, first->patch, control[0]);
    haptable_pair_controls(tables, second->patch, control[1]);
    for (int j = 0; j < count; ++j) r[j] = 0.0f;
    for (int i = 0; i < count; ++i) {
        const uint32_t k = control[0][i];
        q[i] = 0.0f;
        if (k == HAPTABLE_NONE) continue;
        for (int j = 0; j < count; ++j) {
            const uint32_t l = control[1][j];
            if (l == HAPTABLE_NONE) continue;
            const float pull = mat_bilinear(block_between(tables, k, l), by[k < l][0], by[k < l][1]);
            q[i] += second->weight[j] * pull;
            r[j] += first->weight[i] * pull;
        }
    }
}
