/* SPDX-License-Identifier: MIT
 *
 * u_r = sum over the loaded vertices of L_ri F_i (eq. 8)
 *
 * The displacement of a few chosen points of the body, for a part with a display. Independent of the servo's tick: it
 * reads the nodal forces of a tick's output, at the display's own rate. Tables: display.h and display.c, which codegen
 * writes where the scene names [tables] display_rows; elsewhere nothing of this is linked.
 */
#ifndef HAPTABLE_DEFORMATION_H
#define HAPTABLE_DEFORMATION_H

#include "haptable_model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Adds the displacement that a force on one vertex causes: displacement += L[:, vertex] force. */
typedef void haptable_column_fn(const struct haptable_deformation* deformation, uint16_t vertex, const float force_n[3],
                                float (*displacement_m)[3]);

/* The tables of one object's display. const, so that they stay in flash. */
struct haptable_deformation {
    uint64_t model_hash; /* of the servo's tables, which number the vertices */
    uint16_t row_count;
    uint16_t free_count;               /* vertices that have a column; the others are fixed */
    const uint32_t* node;              /* [row_count] mesh node of each row */
    const float (*rest_m)[3];          /* [row_count] rest positions */
    haptable_column_fn* add;           /* one of those below: it says which of the next are used */
    const float (*column_m_per_n)[9];  /* [free_count x row_count] 3x3 blocks of L, row by row */
    const int16_t (*packed)[9];        /* the same, in steps of the vertex' scale */
    const float* packed_scale_m_per_n; /* [free_count] */
};

/* float32: 36 bytes a vertex and row. */
haptable_column_fn haptable_column_float32;

/* int16: half of that; each block is within half a step of it, the step is the column's largest entry / 32767. */
haptable_column_fn haptable_column_int16;

#ifdef __cplusplus
}
#endif

#endif
