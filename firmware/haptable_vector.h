/* SPDX-License-Identifier: MIT
 *
 * Three floats. Everything is inlined: a servo step makes no calls for its arithmetic. But where the compiler is asked
 * for small code (-Os), what is HAPTABLE_INLINE is called, and the linker keeps one of it: a call takes 10 bytes of a
 * Cortex-M4's flash, a product of two vectors 40.
 */
#ifndef HAPTABLE_VECTOR_H
#define HAPTABLE_VECTOR_H

#include <stdint.h>

#if defined(__OPTIMIZE_SIZE__) && defined(__GNUC__) && !defined(__cplusplus)
#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#define HAPTABLE_INLINE __attribute__((weak, noinline))
#define HAPTABLE_CALLED static __attribute__((noinline))
#define across_begin haptable_across_begin
#define across_next haptable_across_next
#define corner_of haptable_corner_of
#define edge_to haptable_edge_to
#define feature_of haptable_feature_of
#define fan_begin haptable_fan_begin
#define fan_next haptable_fan_next
#define gap2(a, b) haptable_gap2(a, b)
#define leads_between haptable_leads_between
#define patch_frame haptable_patch_frame
#define place(model, contact) haptable_place(model, contact)
#define side_of_patch haptable_side_of_patch
#define side_of_plane haptable_side_of_plane
#define vec_add_scaled haptable_vec_add_scaled
#define vec_copy haptable_vec_copy
#define vec_cross haptable_vec_cross
#define vec_dot haptable_vec_dot
#define vec_inverse_root haptable_vec_inverse_root
#define vec_length2 haptable_vec_length2
#define vec_sub haptable_vec_sub
#define vec_symmetric_product haptable_vec_symmetric_product
#define vec_zero haptable_vec_zero
#define vertex_after haptable_vertex_after
#define vertex_before haptable_vertex_before
#else
#define HAPTABLE_INLINE static inline
#define HAPTABLE_CALLED static inline
#endif

/* Before a loop of three, or of six, that a tick runs: its rounds one after the other, and with -Os a loop. */
#if !defined(__GNUC__) || defined(__clang__)
#define HAPTABLE_UNROLLED
#define HAPTABLE_UNROLLED_SIX
#elif defined(__OPTIMIZE_SIZE__)
#define HAPTABLE_UNROLLED _Pragma("GCC unroll 1")
#define HAPTABLE_UNROLLED_SIX _Pragma("GCC unroll 1")
#else
#define HAPTABLE_UNROLLED _Pragma("GCC unroll 3")
#define HAPTABLE_UNROLLED_SIX _Pragma("GCC unroll 6")
#endif

/* vec_inverse_root is one between these. */
#define HAPTABLE_ROOT_LEAST 1e-30f
#define HAPTABLE_ROOT_MOST 1e30f

/* More than any energy, J, or distance squared, m^2. */
#define HAPTABLE_MOST 3e38f

/* Newtons squared: a force below it is none. */
#define HAPTABLE_NO_FORCE2 1e-24f

HAPTABLE_INLINE float vec_dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

HAPTABLE_INLINE float vec_length2(const float a[3]) { return vec_dot(a, a); }

HAPTABLE_INLINE void vec_sub(const float a[3], const float b[3], float out[3]) {
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) out[i] = a[i] - b[i];
}

HAPTABLE_INLINE void vec_add(const float a[3], const float b[3], float out[3]) {
    out[0] = a[0] + b[0];
    out[1] = a[1] + b[1];
    out[2] = a[2] + b[2];
}

HAPTABLE_INLINE void vec_cross(const float a[3], const float b[3], float out[3]) {
    int j = 1;
    int k = 2;
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) {
        out[i] = a[j] * b[k] - a[k] * b[j];
        j = k;
        k = i;
    }
}

HAPTABLE_INLINE void vec_copy(const float a[3], float out[3]) {
    out[0] = a[0];
    out[1] = a[1];
    out[2] = a[2];
}

HAPTABLE_INLINE void vec_zero(float out[3]) { out[0] = out[1] = out[2] = 0.0f; }

/* out += s * a */
HAPTABLE_INLINE void vec_add_scaled(float s, const float a[3], float out[3]) {
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) out[i] += s * a[i];
}

/* a *= s */
static inline void vec_scale(float s, float a[3]) {
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) a[i] *= s;
}

/* sum += part, with what the sum does not hold kept in low (Kahan 1965). */
static inline void add_whole(float part, float* sum, float* low) {
    const float corrected = part - *low;
    const float next = *sum + corrected;
    *low = (next - *sum) - corrected;
    *sum = next;
}

/* f = S u for a symmetric S stored as xx yy zz xy yz zx. */
HAPTABLE_INLINE void vec_symmetric_product(const float s[6], const float u[3], float f[3]) {
    static const uint8_t at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) f[i] = s[at[i][0]] * u[0] + s[at[i][1]] * u[1] + s[at[i][2]] * u[2];
}

/* Not a number, three times. */
static inline void vec_no_number(float out[3]) {
    const float zero = 0.0f;
    /* cppcheck-suppress duplicateExpression */
    out[0] = out[1] = out[2] = zero / zero;
}

/* |x| */
static inline float vec_magnitude(float x) {
#if defined(__GNUC__) && !defined(__cplusplus)
    return __builtin_fabsf(x);
#else
    return x < 0.0f ? -x : x;
#endif
}

static inline float vec_clamp01(float x) { return x < 0.0f ? 0.0f : (x > 1.0f ? 1.0f : x); }

/* 1 / sqrt(x) for HAPTABLE_ROOT_LEAST <= x <= HAPTABLE_ROOT_MOST: a first guess from the exponent, then Newton's steps
 * y (3 - x y^2) / 2, each of which doubles the digits: 3.4e-2, 1.8e-3, 4.7e-6, below a float's rounding. No libm, the
 * same bits everywhere. For 0 and what rounding leaves below it a finite number. */
static inline float vec_inverse_root_by(float x, int steps) {
    union {
        float number;
        uint32_t bits;
    } guess;
    guess.number = x;
    guess.bits = 0x5f3759dfu - (guess.bits >> 1);
    float y = guess.number;
    HAPTABLE_UNROLLED
    for (int k = 0; k < steps; ++k) y = y * (1.5f - 0.5f * x * y * y);
    return y;
}
HAPTABLE_INLINE float vec_inverse_root(float x) { return vec_inverse_root_by(x, 3); }

/* x < 1 of a number, by the bits that a root begins with. */
static inline int vec_is_below_one(float x) {
    union {
        float number;
        int32_t bits;
    } of;
    of.number = x;
    return of.bits < 0x3f800000;
}

#endif
