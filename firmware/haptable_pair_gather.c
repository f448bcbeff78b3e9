/* SPDX-License-Identifier: MIT
 *
 * x_k = sum_l w_l C_kl of a patch, from the blocks of both. A file of its own, so that its sums are inlined.
 */
#include "haptable_pair_terms.h"

void haptable_pair_put_rows(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger) {
    const int count = pair_count(tables->law);
    const size_t next = finger == 0 ? 9 : 9 * (size_t)count; /* from one control of the other's to the next */
    struct haptable_pair_view* view = &pair->view[finger];
    const struct haptable_pair_net* net =
        haptable_pair_net_of(tables, &pair->net, pair->servo[0].contact.patch, pair->servo[1].contact.patch);
    int k;
    view->rows[0].patch = pair->servo[finger].contact.patch;
    for (k = 0; k < count; ++k) {
        float* x = view->rows[0].x[k];
        pair_sum(count, view->place.weight, net->block[finger == 0 ? k * count : k], next, x);
        if (finger == 1) mat_transpose(x);
    }
}
