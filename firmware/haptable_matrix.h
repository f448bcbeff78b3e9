/* SPDX-License-Identifier: MIT
 *
 * C = L D L^T, and 3x3 matrices. Symmetric ones are xx yy zz xy yz zx, others row by row. Everything is inlined, and
 * every number is a statement of its own, which compilers keep in registers.
 */
#ifndef HAPTABLE_MATRIX_H
#define HAPTABLE_MATRIX_H

#include "haptable_vector.h"

#include <stddef.h>

/* ---- symmetric --------------------------------------------------------------------------------------------------- */

static inline float sym_third_of_trace(const float s[6]) { return (s[0] + s[1] + s[2]) * (1.0f / 3.0f); }

static inline void sym_copy(const float s[6], float out[6]) {
    for (int i = 0; i < 6; ++i) out[i] = s[i];
}

/* C = L D L^T of a symmetric positive definite C, D inverted. */
struct sym_factored {
    float inverse[3]; /* 1 / D */
    float l10, l20, l21;
};

static inline struct sym_factored sym_factor(const float c[6]) {
    struct sym_factored f;
    f.inverse[0] = 1.0f / c[0];
    f.l10 = c[3] * f.inverse[0];
    f.l20 = c[5] * f.inverse[0];
    const float d1 = c[1] - f.l10 * c[3];
    f.inverse[1] = 1.0f / d1;
    f.l21 = (c[4] - f.l20 * c[3]) * f.inverse[1];
    const float d2 = c[2] - f.l20 * c[5] - f.l21 * f.l21 * d1;
    f.inverse[2] = 1.0f / d2;
    return f;
}

static inline void sym_solve(const struct sym_factored* f, const float b[3], float x[3]) {
    const float y1 = b[1] - f->l10 * b[0];
    const float y2 = b[2] - f->l20 * b[0] - f->l21 * y1;
    x[2] = y2 * f->inverse[2];
    x[1] = y1 * f->inverse[1] - f->l21 * x[2];
    x[0] = b[0] * f->inverse[0] - f->l10 * x[1] - f->l20 * x[2];
}

/* C^-1 b of one b: the 2x2 that is left without C_00 by Cramer's rule, so that two divisions wait for one another, and
 * not three. */
static inline void sym_solve_once(const float c[6], const float b[3], float x[3]) {
    const float scale0 = 1.0f / c[0];
    const float l10 = c[3] * scale0;
    const float l20 = c[5] * scale0;
    const float d11 = c[1] - l10 * c[3];
    const float d12 = c[4] - l10 * c[5];
    const float d22 = c[2] - l20 * c[5];
    const float y1 = b[1] - l10 * b[0];
    const float y2 = b[2] - l20 * b[0];
    const float scale = 1.0f / (d11 * d22 - d12 * d12);
    x[1] = (d22 * y1 - d12 * y2) * scale;
    x[2] = (d11 * y2 - d12 * y1) * scale;
    x[0] = b[0] * scale0 - l10 * x[1] - l20 * x[2];
}

/* The inverse of a symmetric positive definite matrix, by its cofactors. */
static inline void sym_invert(const float a[6], float inverse[6]) {
    const float xx = a[1] * a[2] - a[4] * a[4];
    const float xy = a[4] * a[5] - a[3] * a[2];
    const float zx = a[3] * a[4] - a[1] * a[5];
    const float scale = 1.0f / (a[0] * xx + a[3] * xy + a[5] * zx);
    inverse[0] = scale * xx;
    inverse[1] = scale * (a[0] * a[2] - a[5] * a[5]);
    inverse[2] = scale * (a[0] * a[1] - a[3] * a[3]);
    inverse[3] = scale * xy;
    inverse[4] = scale * (a[3] * a[5] - a[0] * a[4]);
    inverse[5] = scale * zx;
}

/* ---- row by row -------------------------------------------------------------------------------------------------- */

static inline void mat_product(const float x[9], const float v[3], float out[3]) {
    out[0] = x[0] * v[0] + x[1] * v[1] + x[2] * v[2];
    out[1] = x[3] * v[0] + x[4] * v[1] + x[5] * v[2];
    out[2] = x[6] * v[0] + x[7] * v[1] + x[8] * v[2];
}

static inline void mat_transposed_product(const float x[9], const float v[3], float out[3]) {
    out[0] = x[0] * v[0] + x[3] * v[1] + x[6] * v[2];
    out[1] = x[1] * v[0] + x[4] * v[1] + x[7] * v[2];
    out[2] = x[2] * v[0] + x[5] * v[1] + x[8] * v[2];
}

static inline float mat_bilinear(const float x[9], const float v[3], const float w[3]) {
    float xw[3];
    mat_product(x, w, xw);
    return vec_dot(v, xw);
}

/* out += w X */
static inline void mat_add(float w, const float x[9], float out[9]) {
    out[0] += w * x[0];
    out[1] += w * x[1];
    out[2] += w * x[2];
    out[3] += w * x[3];
    out[4] += w * x[4];
    out[5] += w * x[5];
    out[6] += w * x[6];
    out[7] += w * x[7];
    out[8] += w * x[8];
}

/* out += w X^T */
static inline void mat_add_transposed(float w, const float x[9], float out[9]) {
    out[0] += w * x[0];
    out[1] += w * x[3];
    out[2] += w * x[6];
    out[3] += w * x[1];
    out[4] += w * x[4];
    out[5] += w * x[7];
    out[6] += w * x[2];
    out[7] += w * x[5];
    out[8] += w * x[8];
}

/* out = w X */
static inline void mat_scale(float w, const float x[9], float out[9]) {
    out[0] = w * x[0];
    out[1] = w * x[1];
    out[2] = w * x[2];
    out[3] = w * x[3];
    out[4] = w * x[4];
    out[5] = w * x[5];
    out[6] = w * x[6];
    out[7] = w * x[7];
    out[8] = w * x[8];
}

static inline void mat_copy(const float x[9], float out[9]) {
    vec_copy(&x[0], &out[0]);
    vec_copy(&x[3], &out[3]);
    vec_copy(&x[6], &out[6]);
}

static inline void mat_swap(float* a, float* b) {
    const float was = *a;
    *a = *b;
    *b = was;
}

static inline void mat_transpose(float x[9]) {
    mat_swap(&x[1], &x[3]);
    mat_swap(&x[2], &x[6]);
    mat_swap(&x[5], &x[7]);
}

/* X M and a - X M X^T */
static inline void sym_reduce(const float a[6], const float x[9], const float m[6], float* restrict xm,
                              float* restrict n) {
    vec_symmetric_product(m, &x[0], &xm[0]); /* M is symmetric: a row of X M */
    vec_symmetric_product(m, &x[3], &xm[3]);
    vec_symmetric_product(m, &x[6], &xm[6]);
    n[0] = a[0] - vec_dot(&xm[0], &x[0]);
    n[1] = a[1] - vec_dot(&xm[3], &x[3]);
    n[2] = a[2] - vec_dot(&xm[6], &x[6]);
    n[3] = a[3] - vec_dot(&xm[0], &x[3]);
    n[4] = a[4] - vec_dot(&xm[3], &x[6]);
    n[5] = a[5] - vec_dot(&xm[6], &x[0]);
}

#endif
