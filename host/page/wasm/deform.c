/* SPDX-License-Identifier: MIT */
#include "deform.h"

/* binary16 by binary32's own arithmetic: its bits moved to a float's place are the number times 2^-112. */
static float from_half(uint16_t half) {
    union {
        uint32_t bits;
        float number;
    } both;
    both.bits = (uint32_t)(half & 0x7FFFu) << 13;
    both.number *= 0x1p112f;
    both.bits |= (uint32_t)(half & 0x8000u) << 16;
    return both.number;
}

/* Blocks before those of a column. */
static uint32_t begin_of(const struct page_columns* columns, uint32_t column) {
    return column * columns->row_count - column * (column - (column > 0)) / 2u;
}

static void read_block(const struct page_columns* columns, uint32_t block, float b[9]) {
    uint32_t k;
    for (k = 0; k < 9; ++k)
        b[k] = columns->single ? columns->single[9u * block + k] : from_half(columns->half[9u * block + k]);
}

/* u += B f; of its transposed, where it stands on the other side of the diagonal. */
static void multiply(const float b[9], const float f[3], float u[3]) {
    u[0] += b[0] * f[0] + b[1] * f[1] + b[2] * f[2];
    u[1] += b[3] * f[0] + b[4] * f[1] + b[5] * f[2];
    u[2] += b[6] * f[0] + b[7] * f[1] + b[8] * f[2];
}

static void multiply_transposed(const float b[9], const float f[3], float u[3]) {
    u[0] += b[0] * f[0] + b[3] * f[1] + b[6] * f[2];
    u[1] += b[1] * f[0] + b[4] * f[1] + b[7] * f[2];
    u[2] += b[2] * f[0] + b[5] * f[1] + b[8] * f[2];
}

void page_deform_clear(const struct page_columns* columns, float* u_m) {
    uint32_t k;
    for (k = 0; k < 3u * columns->row_count; ++k) u_m[k] = 0.0f;
}

void page_deform_add(const struct page_columns* columns, uint32_t column, const float force_n[3], float* u_m) {
    const float unit = columns->unit_m_per_n;
    const float f[3] = {unit * force_n[0], unit * force_n[1], unit * force_n[2]};
    float b[9];
    uint32_t row;
    for (row = 0; row < column; ++row) {
        read_block(columns, begin_of(columns, row) + column - row, b);
        multiply_transposed(b, f, u_m + 3u * row);
    }
    for (; row < columns->row_count; ++row) {
        read_block(columns, begin_of(columns, column) + row - column, b);
        multiply(b, f, u_m + 3u * row);
    }
}

static void add_control(const struct page_columns* columns, const struct page_spread* spread, int32_t control,
                        float share, const float load_n[3], float* u_m) {
    int32_t i;
    for (i = spread->begin[control]; i < spread->begin[control + 1]; ++i) {
        const float w = share * spread->weight[i];
        const float force_n[3] = {w * load_n[0], w * load_n[1], w * load_n[2]};
        if (spread->column[i] >= 0 && w != 0.0f) page_deform_add(columns, (uint32_t)spread->column[i], force_n, u_m);
    }
}

static float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void page_deform_add_spread(const struct page_columns* columns, const struct page_spread* spread,
                            const uint16_t vertex[3], uint16_t patch, const float nodal_force_n[3][3], float* u_m) {
    float load_n[3] = {0.0f, 0.0f, 0.0f}, alpha[3];
    float size;
    int c;
    for (c = 0; c < 9; ++c) load_n[c % 3] += nodal_force_n[c / 3][c % 3];
    size = dot(load_n, load_n);
    if (!(size > 0.0f)) return;
    for (c = 0; c < 3; ++c) alpha[c] = dot(nodal_force_n[c], load_n) / size;
    for (c = 0; c < 3; ++c) {
        add_control(columns, spread, spread->vertex_control[vertex[c]], alpha[c] * alpha[c], load_n, u_m);
        add_control(columns, spread, spread->edge_control[3 * patch + c],
                    2.0f * alpha[(c + 1) % 3] * alpha[(c + 2) % 3], load_n, u_m);
    }
}

void page_deform_add_modes(const struct page_columns* columns, const struct page_modes* modes, const float* q,
                           float* u_m) {
    uint32_t row, k, a;
    for (row = 0; row < columns->row_count; ++row)
        for (k = 0; k < modes->count; ++k)
            for (a = 0; a < 3; ++a) u_m[3u * row + a] += modes->row[row * modes->count + k][a] * q[k];
}
