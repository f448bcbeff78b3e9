/* SPDX-License-Identifier: MIT
 *
 * The only place that reads stored blocks: symmetric 3x3 matrices as xx yy zz xy yz zx.
 */
#ifndef HAPTABLE_BLOCK_H
#define HAPTABLE_BLOCK_H

#include "haptable_model.h"
#include "haptable_vector.h"

/* S of a free vertex: where it stands in flash, or expanded into `room` where it is stored in 16 bits.
 * before: vertex < free_count. */
static inline const float* block_of(const struct haptable_model* model, uint16_t vertex, float room[6]) {
    if (model->unpack == 0) return model->stiffness_n_per_m[vertex];
    model->unpack(model, vertex, room);
    return room;
}

/* f = S_v u of one vertex (eq. 9). A fixed one has S = rigid_stiffness I. */
static inline void block_product(const struct haptable_model* model, uint16_t vertex, const float u[3], float f[3]) {
    if (vertex < model->free_count) {
        float room[6];
        vec_symmetric_product(block_of(model, vertex, room), u, f);
    } else {
        vec_zero(f);
        vec_add_scaled(model->rigid_stiffness_n_per_m, u, f);
    }
}

#endif
