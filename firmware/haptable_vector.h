/* SPDX-License-Identifier: MIT
 *
 * Three floats. Everything is inlined: a servo step makes no calls for its arithmetic.
 */
#ifndef HAPTABLE_VECTOR_H
#define HAPTABLE_VECTOR_H

#include <stdint.h>

/* vec_inverse_root is one between these. */
#define HAPTABLE_ROOT_LEAST 1e-30f
#define HAPTABLE_ROOT_MOST 1e30f

/* Newtons squared: a force below it is none. */
#define HAPTABLE_NO_FORCE2 1e-24f

static inline float vec_dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void vec_sub(const float a[3], const float b[3], float out[3]) {
    out[0] = a[0] - b[0];
    out[1] = a[1] - b[1];
    out[2] = a[2] - b[2];
}

static inline void vec_add(const float a[3], const float b[3], float out[3]) {
    out[0] = a[0] + b[0];
    out[1] = a[1] + b[1];
    out[2] = a[2] + b[2];
}

static inline void vec_cross(const float a[3], const float b[3], float out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void vec_copy(const float a[3], float out[3]) {
    out[0] = a[0];
    out[1] = a[1];
    out[2] = a[2];
}

static inline void vec_zero(float out[3]) { out[0] = out[1] = out[2] = 0.0f; }

/* out += s * a */
static inline void vec_add_scaled(float s, const float a[3], float out[3]) {
    out[0] += s * a[0];
    out[1] += s * a[1];
    out[2] += s * a[2];
}

/* f = S u for a symmetric S stored as xx yy zz xy yz zx. */
static inline void vec_symmetric_product(const float s[6], const float u[3], float f[3]) {
    f[0] = s[0] * u[0] + s[3] * u[1] + s[5] * u[2];
    f[1] = s[3] * u[0] + s[1] * u[1] + s[4] * u[2];
    f[2] = s[5] * u[0] + s[4] * u[1] + s[2] * u[2];
}

/* Not a number, three times. */
static inline void vec_no_number(float out[3]) {
    const float zero = 0.0f;
    out[0] = out[1] = out[2] = zero / zero; /* cppcheck-suppress duplicateExpression */
}

static inline float vec_clamp01(float x) { return x < 0.0f ? 0.0f : (x > 1.0f ? 1.0f : x); }

/* 1 for a number, 0 for a NaN or an infinity: x - x is NaN for both. */
static inline int vec_finite(const float a[3]) {
    const float zero = (a[0] - a[0]) + (a[1] - a[1]) + (a[2] - a[2]);
    return zero == 0.0f;
}

/* 1 / sqrt(x) for HAPTABLE_ROOT_LEAST <= x <= HAPTABLE_ROOT_MOST: a first guess from the exponent, then Newton's steps
 * y (3 - x y^2) / 2, each of which doubles the digits: 3.4e-2, 1.8e-3, 4.7e-6, below a float's rounding. No libm, the
 * same bits everywhere. */
static inline float vec_inverse_root(float x) {
    union {
        float number;
        uint32_t bits;
    } guess;
    float y;
    int step;
    guess.number = x;
    guess.bits = 0x5f3759dfu - (guess.bits >> 1);
    y = guess.number;
    for (step = 0; step < 3; ++step) y = y * (1.5f - 0.5f * x * y * y);
    return y;
}

#endif
