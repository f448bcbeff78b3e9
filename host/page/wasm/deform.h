/* SPDX-License-Identifier: MIT
 *
 * u_r = sum over the loaded nodes i of L_ri F_i (equation 8) + sum phi_kr q_k, for a picture in a page.
 *
 * L is symmetric: L_ri = L_ir^T. So of the rows that are columns too only the half from the diagonal on is kept. Rows
 * stand in the order of the columns, and after them those of nodes that have no column.
 */
#ifndef PAGE_DEFORM_H
#define PAGE_DEFORM_H

#include <stdint.h>

/* Columns: of column i the blocks [row_count - i, 3, 3] of rows i and on, row by row. In float32 (half null) m/N; in
 * binary16 (single null) in steps of unit_m_per_n. */
struct page_columns {
    uint32_t column_count, row_count; /* column_count <= row_count */
    float unit_m_per_n;
    const float* single;
    const uint16_t* half;
};

/* How a mask spreads the load of a contact: control points are the touchable vertices, and after them the edges.
 * A vertex weighs alpha_v^2, an edge 2 alpha_v alpha_w. column is -1 for a node that does not move. */
struct page_spread {
    const int32_t* vertex_control; /* [vertex_count] of the model's vertices */
    const int32_t* edge_control;   /* [patch_count, 3] the edge opposite to a corner */
    const int32_t* begin;          /* [controls + 1] */
    const int32_t* column;
    const float* weight;
};

/* How the modes of a body that rings move it. */
struct page_modes {
    uint32_t count;        /* 0: it follows at once */
    const float (*row)[3]; /* [row_count, count] phi, 1/sqrt(kg) */
};

/* u [row_count, 3] = 0. */
void page_deform_clear(const struct page_columns* columns, float* u_m);

/* u += L_i F. before: column < column_count. */
void page_deform_add(const struct page_columns* columns, uint32_t column, const float force_n[3], float* u_m);

/* Adds what a load on a patch, by its shares at the corners, gives through a mask. */
void page_deform_add_spread(const struct page_columns* columns, const struct page_spread* spread,
                            const uint16_t vertex[3], uint16_t patch, const float nodal_force_n[3][3], float* u_m);

/* u += sum phi_k q_k. */
void page_deform_add_modes(const struct page_columns* columns, const struct page_modes* modes, const float* q,
                           float* u_m);

#endif
