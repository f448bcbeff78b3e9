/* SPDX-License-Identifier: MIT
 *
 * X = sum_kl w_k w_l C_kl of two contacts. A file of its own, so that its sums are inlined.
 */
#include "haptable_pair_terms.h"

/* X of two contacts, apart or meeting. */
static inline void pair_cross_net(int count, const struct haptable_pair_net* net, const float first[],
                                  const float second[], float x[9]) {
    const float* block = net->block[0];
    int k = 0;
    do {
        float row[9];
        pair_sum(count, second, block, 9, row);
        if (k == 0)
            mat_scale(first[0], row, x);
        else
            mat_add(first[k], row, x);
        block += 9 * (size_t)count;
    } while (++k < count);
}

void haptable_pair_cross_contacts(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                                  const struct haptable_contact* first, const struct haptable_contact* second,
                                  float x[9]) {
    const int count = pair_count(tables->law);
    const struct haptable_pair_net* net = haptable_pair_net_of(tables, &pair->net, first->patch, second->patch);
    const float near = 1.0f - gap2(first->god_object_m, second->god_object_m) / (tables->meeting_m * tables->meeting_m);
    float weight[HAPTABLE_FINGERS][HAPTABLE_PAIR_CONTROLS];
    pair_weights(count, first->alpha, weight[0]);
    pair_weights(count, second->alpha, weight[1]);
    pair_cross_net(count, net, weight[0], weight[1], x);
    if (near > 0.0f) mat_scale(1.0f - HAPTABLE_PAIR_MEETING * near * near, x, x);
}
